//! Extrinsics: the position and the direction of a camera.

use glam::{DQuat, DVec3};

/// A world-to-camera transform: `camera = rotation * world + translation`. Camera axes: x right, y down, z forward.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// World-to-camera rotation, unit.
    pub rotation: DQuat,
    /// World-to-camera translation: not the camera's centre.
    pub translation: DVec3,
}

impl Pose {
    /// The pose of a camera at `eye` that looks at `target`, with `up` upwards in the image; all in world coordinates.
    pub fn look_at(eye: DVec3, target: DVec3, up: DVec3) -> Pose {
        let z = (target - eye).normalize();
        let x = z.cross(up).normalize();
        let to_world = glam::DMat3::from_cols(x, z.cross(x), z);
        let rotation = DQuat::from_mat3(&to_world.transpose()).normalize();
        Pose { rotation, translation: -(rotation * eye) }
    }

    /// The centre of projection, in world coordinates.
    pub fn centre(&self) -> DVec3 {
        self.rotation.inverse() * -self.translation
    }

    /// A world point in camera coordinates.
    pub fn to_camera(&self, world: DVec3) -> DVec3 {
        self.rotation * world + self.translation
    }

    /// A camera direction in the world.
    pub fn to_world(&self, direction: DVec3) -> DVec3 {
        self.rotation.inverse() * direction
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn look_at_puts_the_target_on_the_axis() {
        let (eye, target) = (DVec3::new(3.0, -2.0, 10.0), DVec3::new(1.0, 1.0, 0.0));
        let pose = Pose::look_at(eye, target, DVec3::Z);
        assert!(pose.centre().distance(eye) < 1e-12);
        let seen = pose.to_camera(target);
        assert!(seen.x.abs() < 1e-12 && seen.y.abs() < 1e-12 && seen.z > 0.0, "{seen}");
        // Up in the world is up in the image: y points down.
        assert!(pose.to_camera(target + DVec3::Z).y < 0.0);
    }
}
