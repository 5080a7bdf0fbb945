//! Instances: placement of meshes in a world.

use crate::context::{overcoat, run};
use crate::raw;
use crate::status::{Failure, overcoat_status};
use crate::world::transform;
use renderer::world::{InstanceHandle, MaterialHandle, MeshHandle, ModelHandle};

/// Places a mesh, made of a material. `matrix` may be null: as it is.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_add_instance(
    overcoat: *mut overcoat,
    world: u64,
    mesh: u64,
    material: u64,
    matrix: *const f64,
    instance_out: *mut u64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let place = transform(matrix)?;
            let (mesh, material) = (MeshHandle::from_bits(mesh), MaterialHandle::from_bits(material));
            let handle = inner.world(world)?.add_instance(mesh, material, place)?;
            raw::write(instance_out, handle.to_bits());
            Ok(())
        })
    }
}

/// Moves an instance: where it is in the world or, of a model's instance, in its model.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_set_transform(
    overcoat: *mut overcoat,
    world: u64,
    instance: u64,
    matrix: *const f64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let place = transform(matrix)?;
            Ok(inner.world(world)?.set_transform(InstanceHandle::from_bits(instance), place)?)
        })
    }
}

/// Hides an instance, or shows it again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_set_visible(
    overcoat: *mut overcoat,
    world: u64,
    instance: u64,
    visible: bool,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            Ok(inner.world(world)?.set_visible(InstanceHandle::from_bits(instance), visible)?)
        })
    }
}

/// Makes an instance one of another material.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_set_instance_material(
    overcoat: *mut overcoat,
    world: u64,
    instance: u64,
    material: u64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let (instance, material) =
                (InstanceHandle::from_bits(instance), MaterialHandle::from_bits(material));
            Ok(inner.world(world)?.set_instance_material(instance, material)?)
        })
    }
}

/// Removes an instance. Its mesh and its material stay.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_remove_instance(
    overcoat: *mut overcoat,
    world: u64,
    instance: u64,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            Ok(inner.world(world)?.remove_instance(InstanceHandle::from_bits(instance))?)
        })
    }
}

/// The number of a model's instances goes to `count_out`, and as many of their names as `capacity` has room for to `instances_out`,
/// which may be null if that is 0.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn overcoat_model_instances(
    overcoat: *mut overcoat,
    world: u64,
    model: u64,
    instances_out: *mut u64,
    capacity: usize,
    count_out: *mut usize,
) -> overcoat_status {
    // SAFETY: of the caller.
    unsafe {
        run(overcoat, |inner, _| {
            let all = inner.world(world)?.model_instances(ModelHandle::from_bits(model))?;
            if instances_out.is_null() && capacity > 0 {
                return Err(Failure::argument("instances_out: null"));
            }
            for (k, instance) in all.iter().take(capacity).enumerate() {
                raw::write(instances_out.wrapping_add(k), instance.to_bits());
            }
            raw::write(count_out, all.len());
            Ok(())
        })
    }
}
