//! Command-line options of `simplify` and `lod` for attributes.

use clap::Args;
use mesh_work::{AttributeRules, Attributes, Loaded};

use crate::args::{parse_angle, parse_not_negative};
use crate::console::Console;
use crate::failure::Failure;

/// The options of [`Carry`] that have no effect without attributes.
pub(crate) const OF_ATTRIBUTES: [&str; 4] =
    ["attribute_weight", "normal_weight", "crease_angle", "keep_creases"];

/// The reason for refusing them for a mesh that is simplified region by region.
pub(crate) const ONLY_SHAPES: &str = "only positions and faces go through regions; give --memory what the whole mesh needs, or leave it out";

/// What becomes of texture coordinates, normals, colours and materials.
#[derive(Debug, Args)]
#[command(next_help_heading = "Attributes")]
pub(crate) struct Carry {
    /// How much shifts of texture and colours count; 0 for not at all. At 1 a texture that shifts by
    /// one model unit is as bad as a surface that does, and so is a colour that changes from black
    /// to white on a mesh that measures 100 units
    #[arg(long, value_name = "W", default_value_t = 0.3, value_parser = parse_not_negative)]
    attribute_weight: f64,
    /// How much normals of the file count on top of the shape; 0 for not at all. At 1 a normal that
    /// turns by one radian on a mesh that measures 100 units is as bad as a surface that shifts by one
    #[arg(long, value_name = "W", default_value_t = 0.0, value_parser = parse_not_negative)]
    normal_weight: f64,
    /// Normals of the file that differ by more than this across an edge, or from the simplified
    /// surface, are a crease
    #[arg(long, value_name = "DEGREES", default_value = "40", value_parser = parse_angle)]
    crease_angle: f64,
    /// Keep creases as feature lines, as borders of texture charts, materials and groups are
    #[arg(long)]
    keep_creases: bool,
    /// Leave out texture coordinates, normals, colours, materials and groups
    #[arg(long, conflicts_with_all = OF_ATTRIBUTES)]
    no_attributes: bool,
}

impl Carry {
    /// The rules for the library.
    pub(crate) fn rules(&self) -> AttributeRules {
        AttributeRules {
            attribute_weight: self.attribute_weight,
            normal_weight: self.normal_weight,
            crease_angle: self.crease_angle,
            keep_creases: self.keep_creases,
            carry: !self.no_attributes,
        }
    }

    /// Finds the seams and the attributes of a mesh.
    pub(crate) fn find(&self, loaded: &Loaded, console: &Console) -> Result<Attributes, Failure> {
        let rules = self.rules();
        let attributes = Attributes::find(loaded.source(), &rules).map_err(Failure::simplify)?;
        if attributes.is_flat_shaded() {
            console.message("every face has a normal of its own: normals are left out");
        }
        if attributes.seam_count() > 0 {
            console.message(format_args!("{} edges are seams or creases", attributes.seam_count()));
        }
        Ok(attributes)
    }
}
