//! Promises of the transports that have geometry in place.

use bumper::transport::{MasterEnd, SharedGeometry, TransportError};

use crate::Scene;
use crate::bytes;
use crate::roles::{Role, digest};
use crate::transports::Transport;

fn geometry<T: Transport>(scene: &mut Scene<T>) -> &mut dyn SharedGeometry {
    scene.master().shared_geometry().expect("geometry in place")
}

pub fn promise_1_images_arrive_whole_before_and_after_attaching<T: Transport>() {
    let images = [bytes(64 * 5000), bytes(64 * 3)];
    let mut scene = Scene::<T>::new();
    let copied = geometry(&mut scene).publish(0, &images[0]).unwrap();
    assert_eq!(copied, 64 * 5000);
    let running = [0, 1].map(|slot| scene.start(slot, Role::Geometry));
    // The first image was there before the workers, the second comes while they wait for it.
    for slot in [0, 1] {
        assert_eq!(scene.next(slot), digest(&images[0]));
    }
    geometry(&mut scene).publish(1, &images[1]).unwrap();
    for slot in [0, 1] {
        assert_eq!(scene.next(slot), digest(&images[1]));
    }
    running.into_iter().for_each(|running| running.finish());
}

pub fn promise_1_a_number_is_published_once<T: Transport>() {
    let mut scene = Scene::<T>::new();
    let geometry = geometry(&mut scene);
    let is_refused = |result| matches!(result, Err(TransportError::PublishedBefore(3)));
    geometry.publish(3, b"image").unwrap();
    assert!(is_refused(geometry.publish(3, b"image")));
    geometry.withdraw(3).unwrap();
    assert!(is_refused(geometry.publish(3, b"image")));
    geometry.publish(4, b"image").unwrap();
}

pub fn promise_2_geometry_outlives_the_master<T: Transport>() {
    let image = bytes(64 * 2000);
    let mut scene = Scene::<T>::new();
    geometry(&mut scene).publish(0, &image).unwrap();
    let running = scene.start(0, Role::GeometryBehindGate);
    assert_eq!(scene.next(0), digest(&image));
    scene.master = None;
    scene.gate().open();
    running.finish();
}

/// That its memory comes back in the end is shown for each transport on its own.
pub fn promise_2_a_withdrawn_mesh_stays_with_who_has_it<T: Transport>() {
    let image = bytes(64 * 2000);
    let mut scene = Scene::<T>::new();
    geometry(&mut scene).publish(0, &image).unwrap();
    let running = scene.start(0, Role::GeometryForAWhile);
    assert_eq!(scene.next(0), b"have it");
    geometry(&mut scene).withdraw(0).unwrap();
    scene.send(0, b"look again");
    assert_eq!(scene.collect(0, 2), [&digest(&image)[..], b"had it"]);
    scene.send(0, b"enough");
    running.finish();
}

pub fn promise_11_who_waits_for_geometry_notices_that_the_master_has_gone<T: Transport>() {
    let mut scene = Scene::<T>::new();
    let running = scene.start_and_meet(0, Role::GeometryOrphan);
    scene.master = None;
    running.finish();
}
