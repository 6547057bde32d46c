use super::*;

const MODELS: &str = "[[models]]
name = \"pair\"
fixed = { mesh = \"builtin:tracked\" }
moving = { mesh = \"car.ply\", depth = 2 }
scenarios = { poses = \"poses.csv\" }
";

fn parse(head: &str) -> Result<Evaluation, String> {
    let text = format!("version = 1\n{head}\n{MODELS}");
    let source = Source { text: &text, name: "file", folder: Path::new("folder") };
    Evaluation::parse("own", &source).map_err(|error| error.to_string())
}

#[track_caller]
fn refused(head: &str, words: &[&str]) {
    let error = parse(head).unwrap_err();
    for word in words {
        assert!(error.contains(word), "`{word}` is missing in:\n{error}");
    }
}

#[test]
fn the_embedded_ones_are_the_papers() {
    for name in NAMES {
        let experiment = Evaluation::embedded(name).unwrap();
        assert_eq!(experiment.samples.get(), 3, "three samples (section 7)");
        assert_eq!(experiment.matchmakers, MatchRule::ALL);
        let [heavy, cars] = &experiment.models[..] else { panic!("two pairs of models") };
        assert_eq!([heavy.name.as_str(), &cars.name], ["heavy-car", "car-car"]);
        let depths = |models: &Models| models.scene.cuts();
        use crate::tree::roots::Cut::Depth;
        if name != "depth" {
            assert_eq!([depths(heavy)[0], depths(cars)[0]], [Depth(12), Depth(10)]);
        }
        assert_eq!([depths(heavy)[1], depths(cars)[1]], [Depth(6), Depth(6)]);
        for (models, scenarios) in [(heavy, 3744), (cars, 2723)] {
            let crate::scene::Scenarios::Random(random) = &models.scene.scenarios else {
                panic!("random scenarios")
            };
            assert_eq!(random.count.get(), scenarios);
            assert_eq!(models.scene.engine.transport, Transport::Pipe);
            assert_eq!(models.scene.engine.buffer_scenarios.get(), 20);
        }
    }
}

#[test]
fn files_are_found_next_to_the_experiment() {
    let experiment = parse("vary = { depth = [0, 24] }\nsamples = 1").unwrap();
    let scene = &experiment.models[0].scene;
    assert_eq!(scene.moving.mesh, MeshSource::File("folder/car.ply".into()));
    let file = "folder/poses.csv".into();
    assert_eq!(scene.scenarios, crate::scene::Scenarios::Poses { file, first: None });
    assert_eq!(experiment.vary, Vary::Depth(vec![0, 24]));
}

#[test]
fn what_makes_no_sense_is_refused_with_its_line() {
    refused("", &["vary"]);
    refused("vary = {}", &["file:2", "one thing that is varied"]);
    refused("vary = { depth = [1], buffer = [2] }", &["one thing that is varied"]);
    refused("vary = { depht = [1] }", &["did you mean `depth`"]);
    refused("vary = { depth = [] }", &["vary.depth", "one or more"]);
    refused("vary = { depth = [4, 4] }", &["vary.depth", "greater"]);
    refused("vary = { depth = [25] }", &["vary.depth", "25", "0 to 24"]);
    refused("vary = { buffer = [0] }", &["vary.buffer", "number of scenarios"]);
    refused("vary = { scenarios_percent = [50, 101] }", &["101", "1 to 100"]);
    refused("vary = { units = [{}] }", &["vary.units", "1 to 1024"]);
    refused("vary = { units = [{ fast = 1 }, { fast = 1, slow = 0 }] }", &["twice"]);
    refused("vary = { units = [{ slow = 1 }] }", &["vary.slowdown"]);
    refused("vary = { units = [{ slow = 1 }], slowdown = 0.5 }", &["vary.slowdown", "0.5"]);
    refused("vary = { depth = [1], slowdown = 2.0 }", &["vary.slowdown", "vary.units"]);
    let depth = |line: &str| format!("vary = {{ depth = [1] }}\n{line}");
    refused(&depth("samples = 0"), &["file:3", "samples", "1 to 1000"]);
    refused(&depth("matchmakers = []"), &["matchmakers"]);
    refused(&depth("matchmakers = [\"best\", \"best\"]"), &["matchmakers", "once"]);
    refused(&depth("matchmakers = [\"worst\"]"), &["worst"]);
    refused(&depth("engine = { matchmaker = \"best\" }"), &["engine.matchmaker"]);
    refused(&depth("engine = { wrokers = 1 }"), &["did you mean `workers`"]);
    refused("vary = { units = [{ fast = 1 }] }\nengine = { workers = 1 }", &["engine.workers"]);
    refused("vary = { serial_percent = [9] }\nengine = {}", &["engine", "has none"]);
    refused("vary = { serial_percent = [9] }\nmatchmakers = [\"best\"]", &["matchmakers"]);
    refused("vary = { buffer = [1] }\nengine.buffer.scenarios = 3", &["engine.buffer.scenarios"]);
    let deep = MODELS.replace("tracked\"", "tracked\", depth = 3");
    refused(&depth(&deep), &["models.fixed.depth", "what is varied"]);
    let twice = format!("{}\n{MODELS}", depth(""));
    refused(&twice, &["models.name", "other models"]);
    refused(&twice.replace("\"pair\"", "\"a/b\""), &["models.name", "file names"]);
    let source = Source { text: "version = 2", name: "file", folder: Path::new("") };
    let error = Evaluation::parse("own", &source).unwrap_err().to_string();
    assert!(error.contains("it reads version 1"), "{error}");
}

#[test]
fn models_are_chosen_by_their_names() {
    let mut experiment = Evaluation::embedded("depth").unwrap();
    experiment.choose(&["car-car".to_owned()]).unwrap();
    assert_eq!(experiment.models.len(), 1);
    let error = experiment.choose(&["heavy-car".to_owned()]).unwrap_err().to_string();
    assert!(error.contains("heavy-car") && error.contains("it has car-car"), "{error}");
}

#[test]
fn a_name_that_is_no_file_either_is_told_which_names_there_are() {
    let error = Evaluation::find(Path::new("no-such")).unwrap_err().to_string();
    assert!(NAMES.iter().all(|name| error.contains(name)), "{error}");
}
