use super::transform;
use crate::mesh::Problem;
use crate::mesh::error::excerpt;

/// Looks, lights, sensors, interpolators: nothing that has a surface.
const NOTHING: [&str; 33] = [
    "Appearance",
    "AudioClip",
    "Background",
    "Color",
    "ColorInterpolator",
    "CoordinateInterpolator",
    "CylinderSensor",
    "DirectionalLight",
    "Fog",
    "FontStyle",
    "ImageTexture",
    "Material",
    "MovieTexture",
    "NavigationInfo",
    "Normal",
    "NormalInterpolator",
    "OrientationInterpolator",
    "PixelTexture",
    "PlaneSensor",
    "PointLight",
    "PositionInterpolator",
    "ProximitySensor",
    "ScalarInterpolator",
    "Sound",
    "SphereSensor",
    "SpotLight",
    "TextureCoordinate",
    "TextureTransform",
    "TimeSensor",
    "TouchSensor",
    "Viewpoint",
    "VisibilitySensor",
    "WorldInfo",
];

/// What the node types of VRML97 mean for a mesh.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    /// Holds nodes in the field of this name.
    Group(&'static str),
    Transform,
    Switch,
    LevelOfDetail,
    Faces,
    Coordinate,
    NoSurface,
    /// Declares fields of its own, so that a name may follow a name.
    Script,
    Nothing,
}

impl Kind {
    pub fn parse(name: &[u8]) -> Result<Self, Problem> {
        let unsupported = |remedy| {
            let what = format!("the node {}", excerpt(name));
            Err(Problem::Unsupported { what, remedy })
        };
        match std::str::from_utf8(name).unwrap_or_default() {
            "Group" | "Anchor" | "Billboard" | "Collision" => Ok(Self::Group("children")),
            "Shape" => Ok(Self::Group("geometry")),
            "Transform" => Ok(Self::Transform),
            "Switch" => Ok(Self::Switch),
            "LOD" => Ok(Self::LevelOfDetail),
            "IndexedFaceSet" => Ok(Self::Faces),
            "Coordinate" => Ok(Self::Coordinate),
            "IndexedLineSet" | "PointSet" | "Text" => Ok(Self::NoSurface),
            "Script" => Ok(Self::Script),
            "Inline" => unsupported("put the inlined file's content into this file"),
            "Box" | "Cone" | "Cylinder" | "Sphere" | "ElevationGrid" | "Extrusion" => {
                unsupported("convert it to an IndexedFaceSet")
            }
            name if NOTHING.contains(&name) => Ok(Self::Nothing),
            _ => Err(Problem::unexpected(name, "a node type of VRML97")),
        }
    }

    /// The field whose nodes count.
    pub fn nodes_field(self) -> Option<&'static str> {
        match self {
            Self::Group(field) => Some(field),
            Self::Transform => Some("children"),
            Self::Switch => Some("choice"),
            Self::LevelOfDetail => Some("level"),
            Self::Faces => Some("coord"),
            _ => None,
        }
    }

    pub fn keeps_numbers(self, field: &[u8]) -> bool {
        match self {
            Self::Transform => transform::FIELDS.iter().any(|name| name.as_bytes() == field),
            Self::Switch => field == b"whichChoice",
            Self::Faces => field == b"coordIndex",
            Self::Coordinate => field == b"point",
            _ => false,
        }
    }
}
