//! Command-line options of `simplify` and `lod` for attributes.

use clap::Args;
use mesh_work::{AttributeRules, Attributes, Loaded};

use crate::args::{parse_angle, parse_not_negative};
use crate::console::Console;
use crate::counted::counted;
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
    /// Weight of shifts of texture and colours; 0 for none. At 1, a shift of the texture by one model
    /// unit costs as much as a shift of the surface by one unit. On a mesh that measures 100 units, so
    /// does a change from black to white
    #[arg(long, value_name = "W", default_value_t = 0.3, value_parser = parse_not_negative)]
    attribute_weight: f64,
    /// Weight of the normals of the file, in addition to the shape; 0 for none. At 1, a normal that turns
    /// by one radian on a mesh that measures 100 units costs as much as a shift of the surface by one unit
    #[arg(long, value_name = "W", default_value_t = 0.0, value_parser = parse_not_negative)]
    normal_weight: f64,
    /// Angle at which normals of the file that differ across an edge make it a crease. Normals that differ
    /// more from the simplified surface are computed anew
    #[arg(long, value_name = "DEGREES", default_value = "40", value_parser = parse_angle)]
    crease_angle: f64,
    /// Keep creases as feature lines, like the borders of texture charts, materials and groups
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
            console.message(format_args!(
                "seams and creases: {}",
                counted(attributes.seam_count(), "edges")
            ));
        }
        Ok(attributes)
    }
}
