//! What is printed.

use crate::cold::{Cold, Twice};
use crate::contender::Contender;
use crate::timing::Timings;
use crate::vehicles::Vehicles;
use crate::warm::Warm;

pub fn warm(vehicles: &Vehicles, contenders: &[Contender], timed: &mut [Warm]) {
    queries("all pairs", contenders, timed, |warm| &mut warm.all);
    queries("any, colliding", contenders, timed, |warm| &mut warm.colliding);
    queries("any, near miss", contenders, timed, |warm| &mut warm.near);
    let header = ["N_b", "N_p", "exact", "build ms", "bytes/tri"];
    print!("\n{:16}", "a pose");
    header.iter().for_each(|name| print!(" {name:>10}"));
    println!();
    for (Contender { name, index, .. }, Warm { counts, .. }) in contenders.iter().zip(timed) {
        let (seconds, bytes) = vehicles.builds[*index];
        let [b, p, exact] = [counts.boxes, counts.triangles, counts.exact]
            .map(|count| count as f64 / vehicles.poses.len() as f64);
        print!("{name:16}");
        match bytes {
            Some(bytes) => {
                println!(" {b:10.0} {p:10.0} {exact:10.1} {:10.0} {bytes:10.1}", 1e3 * seconds)
            }
            None => {
                println!(" {:>10} {:>10} {:>10} {:10.0} {:>10}", "-", "-", "-", 1e3 * seconds, "-")
            }
        }
    }
}

fn queries(
    title: &str,
    contenders: &[Contender],
    timed: &mut [Warm],
    timings: impl Fn(&mut Warm) -> &mut Timings,
) {
    println!("\n{title:16} {:>9} {:>9} {:>9} {:>14}", "mean us", "median", "p99", "parry / this");
    let peer = timings(&mut timed[0]).mean_us();
    for (contender, warm) in contenders.iter().zip(timed) {
        let timings = timings(warm);
        let [median, p99] = [0.5, 0.99].map(|q| timings.quantile_us(q));
        let mean = timings.mean_us();
        println!("{:16} {mean:9.1} {median:9.1} {p99:9.1} {:14.1}", contender.name, peer / mean);
    }
}

pub fn cold(vehicles: &Vehicles, contenders: &[Contender], timed: &mut [Cold]) {
    println!("\n{}, all pairs, first cold and at once again", vehicles.name);
    twice("in turn", contenders, timed, |cold| &mut cold.in_turn);
    twice("evicted", contenders, timed, |cold| &mut cold.evicted);
}

fn twice(
    title: &str,
    contenders: &[Contender],
    timed: &mut [Cold],
    timings: impl Fn(&mut Cold) -> &mut Twice,
) {
    println!(
        "\n{title:16} {:>9} {:>9} {:>9} {:>9} {:>14}",
        "mean us", "median", "warm mean", "median", "cold / warm"
    );
    for (contender, cold) in contenders.iter().zip(timed) {
        let Twice { cold, warm } = timings(cold);
        let [(mean, median), (warm_mean, warm_median)] =
            [cold, warm].map(|timings| (timings.mean_us(), timings.quantile_us(0.5)));
        println!(
            "{:16} {mean:9.1} {median:9.1} {warm_mean:9.1} {warm_median:9.1} {:14.2}",
            contender.name,
            mean / warm_mean
        );
    }
}
