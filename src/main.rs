fn main() -> std::process::ExitCode {
    bumper::cli::main()
}
