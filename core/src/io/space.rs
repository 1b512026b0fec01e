//! What a file's numbers mean: its unit, which way is up, which way the face looks.
//!
//! Inside, everything is in centimetres, Y up, +Z front. A [`Space`] says how to get there and back.
//! There is no translation: what was at the file's origin stays at the origin, so that an export lies
//! where the import came from.

use std::str::FromStr;

use glam::{Affine3A, Mat3, Vec3};
use serde::{Deserialize, Serialize};

use crate::mesh::TriMesh;
use crate::strands::Strands;

/// Length of 1 in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Unit {
    #[serde(rename = "mm")]
    Millimetre,
    #[serde(rename = "cm")]
    Centimetre,
    #[serde(rename = "in")]
    Inch,
    #[serde(rename = "m")]
    Metre,
}

impl Unit {
    pub const ALL: [Self; 4] = [Self::Millimetre, Self::Centimetre, Self::Inch, Self::Metre];

    /// Centimetres in one of it.
    pub fn in_cm(self) -> f32 {
        match self {
            Self::Millimetre => 0.1,
            Self::Centimetre => 1.0,
            Self::Inch => 2.54,
            Self::Metre => 100.0,
        }
    }

    /// As the command line and `info` write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Inch => "in",
            Self::Metre => "m",
        }
    }

    pub fn label(self) -> &'static str {
        match self {
            Self::Millimetre => "Millimetres",
            Self::Centimetre => "Centimetres",
            Self::Inch => "Inches",
            Self::Metre => "Metres",
        }
    }
}

impl FromStr for Unit {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|unit| unit.name() == name);
        found.ok_or_else(|| format!("no unit is called `{name}`: use cm, m, mm or in"))
    }
}

/// A signed axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Axis {
    #[serde(rename = "x")]
    X,
    #[serde(rename = "y")]
    Y,
    #[serde(rename = "z")]
    Z,
    #[serde(rename = "-x")]
    NegX,
    #[serde(rename = "-y")]
    NegY,
    #[serde(rename = "-z")]
    NegZ,
}

impl Axis {
    pub const ALL: [Self; 6] = [Self::X, Self::Y, Self::Z, Self::NegX, Self::NegY, Self::NegZ];

    pub fn vector(self) -> Vec3 {
        match self {
            Self::X => Vec3::X,
            Self::Y => Vec3::Y,
            Self::Z => Vec3::Z,
            Self::NegX => Vec3::NEG_X,
            Self::NegY => Vec3::NEG_Y,
            Self::NegZ => Vec3::NEG_Z,
        }
    }

    /// As the command line and `info` write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::X => "x",
            Self::Y => "y",
            Self::Z => "z",
            Self::NegX => "-x",
            Self::NegY => "-y",
            Self::NegZ => "-z",
        }
    }

    pub fn label(self) -> &'static str {
        match self {
            Self::X => "X",
            Self::Y => "Y",
            Self::Z => "Z",
            Self::NegX => "-X",
            Self::NegY => "-Y",
            Self::NegZ => "-Z",
        }
    }

    /// Where the face looks by custom, when this is up: +Z in Y-up programs, -Y in Z-up programs.
    pub fn usual_front(self) -> Self {
        match self {
            Self::Y | Self::NegY => Self::Z,
            Self::X | Self::NegX | Self::Z | Self::NegZ => Self::NegY,
        }
    }

    fn is_along(self, other: Self) -> bool {
        self.vector().dot(other.vector()) != 0.0
    }
}

impl FromStr for Axis {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|axis| axis.name() == name);
        found.ok_or_else(|| format!("no axis is called `{name}`: use y or z (or x, -x, -y, -z)"))
    }
}

/// How a file's numbers map to the world.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub struct Space {
    pub unit: Unit,
    pub up: Axis,
    pub front: Axis,
}

impl Default for Space {
    /// The world's own: centimetres, Y up, +Z front.
    fn default() -> Self {
        Self { unit: Unit::Centimetre, up: Axis::Y, front: Axis::Z }
    }
}

impl Space {
    /// A unit and an up axis with the front that is usual for it.
    pub fn new(unit: Unit, up: Axis) -> Self {
        Self { unit, up, front: up.usual_front() }
    }

    /// In words: "Metres, Y up, Z front".
    pub fn describe(self) -> String {
        format!("{}, {} up, {} front", self.unit.label(), self.up.label(), self.front.label())
    }

    /// The same unit with another up axis and the front that is usual for it.
    pub fn with_up(self, up: Axis) -> Self {
        if self.up == up { self } else { Self::new(self.unit, up) }
    }

    /// Rotation from file axes to world axes; always a proper rotation.
    fn rotation(self) -> Mat3 {
        let up = self.up.vector();
        let front = if self.front.is_along(self.up) { self.up.usual_front() } else { self.front }.vector();
        // Rows are the world's axes in the file's.
        Mat3::from_cols(up.cross(front), up, front).transpose()
    }

    /// Centimetres, Y up, +Z front, from the file's numbers.
    pub fn world_from_file(self) -> Affine3A {
        Affine3A::from_mat3(self.rotation() * self.unit.in_cm())
    }

    /// The file's numbers from the world's.
    pub fn file_from_world(self) -> Affine3A {
        Affine3A::from_mat3(self.rotation().transpose() * (1.0 / self.unit.in_cm()))
    }

    /// Change strands in place from file numbers to world centimetres. Radii are micrometres already.
    pub fn place_strands(self, strands: &mut Strands) {
        if self != Self::default() {
            transform_points(self.world_from_file(), &mut strands.points);
        }
    }

    /// Change a mesh in place from file numbers to world centimetres.
    pub fn place_mesh(self, mesh: &mut TriMesh) {
        if self != Self::default() {
            transform_points(self.world_from_file(), &mut mesh.positions);
            let rotation = self.rotation();
            mesh.normals.iter_mut().for_each(|normal| *normal = rotation * *normal);
        }
    }

    /// Where something lies that was imported as `self` and should have been imported as `right`.
    pub fn correction(self, right: Self) -> Affine3A {
        right.world_from_file() * self.file_from_world()
    }
}

pub(crate) fn transform_points(transform: Affine3A, points: &mut [Vec3]) {
    for p in points {
        *p = transform.transform_point3(*p);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_space_is_a_proper_rotation_times_its_unit_and_undoes_itself() {
        for up in Axis::ALL {
            for front in Axis::ALL {
                for unit in Unit::ALL {
                    let space = Space { unit, up, front };
                    let m = space.world_from_file();
                    let scale = unit.in_cm();
                    assert!((m.matrix3.determinant() / scale.powi(3) - 1.0).abs() < 1e-4, "{space:?} mirrors");
                    assert!((m.transform_vector3(up.vector()) - Vec3::Y * scale).length() < 1e-4 * scale);
                    let p = Vec3::new(0.3, -2.0, 7.0);
                    let back = space.file_from_world().transform_point3(m.transform_point3(p));
                    assert!((back - p).length() < 1e-5, "{space:?}");
                }
            }
        }
    }

    #[test]
    fn z_up_files_face_minus_y() {
        let space = Space::new(Unit::Metre, Axis::Z);
        assert_eq!(space.world_from_file().transform_point3(Vec3::new(1.0, 2.0, 3.0)), Vec3::new(100.0, 300.0, -200.0));
    }
}
