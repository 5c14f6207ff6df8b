//! Command-line options of `curvature` for all estimators.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use mesh_render::Scale;
use mesh_view::{Exhibit, Page};
use mesh_work::{Length, Quantity, parse_length};

use crate::args::{AreaName, EstimatorPreset, parse_count};
use crate::batch::Job;
use crate::colormap::{COLOR_OPTIONS, ColorOptions};
use crate::failure::Failure;
use crate::given::Given;
use crate::streaming::Streaming;
use crate::view::{Look, set_units};

/// Compute the curvature of every vertex or face, and colour the mesh by it
///
/// PLY files have every quantity as a named property; PLY, GLB, OBJ and OFF files have the colours.
/// Signed quantities are positive where the surface is convex, seen from outside. Curvature of faces
/// is a property of faces. GLB and OBJ have colours of vertices only, the mean over the faces around.
///
/// Without -o nothing is written, and only the totals are printed.
///
///     curvmesh curvature scan.ply --json
///     curvmesh curvature scan.ply -o mean.ply --quantity mean
///     curvmesh curvature part.obj -o folds.glb --quantity abs-dihedral --colormap magma --range 0,2
///     curvmesh curvature scan.ply -o k1.ply --quantity k1 --estimator face --radius 1%
///     curvmesh curvature scan.ply -o lines.ply --estimator fit --as arrows
///     curvmesh curvature huge.ply -o huge-mean.ply --quantity mean --memory 1GiB
///     curvmesh curvature noisy.ply -o smooth.ply --estimator ball --radius 2%
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Curvature {
    #[command(flatten)]
    pub(crate) job: Job,
    /// What the colours show
    #[arg(long, default_value_t, value_parser = quantity(), help_heading = "Curvature")]
    pub(crate) quantity: Quantity,
    /// The area that belongs to a vertex, by which integrals are divided
    #[arg(long, value_enum, default_value_t, help_heading = "Curvature")]
    pub(crate) area: AreaName,
    #[command(flatten)]
    pub(crate) colors: ColorOptions,
    #[command(flatten)]
    pub(crate) estimate: Estimate,
    #[command(flatten)]
    pub(crate) look: Look,
    #[command(flatten)]
    pub(crate) streaming: Streaming,
}

/// Where curvature is estimated, and how.
#[derive(Debug, Args)]
#[command(next_help_heading = "Curvature")]
pub(crate) struct Estimate {
    /// How curvature is estimated
    #[arg(long, value_enum, default_value_t)]
    pub(crate) estimator: EstimatorName,
    /// With `face`: length of the sections to either side [default: 4 local edge lengths, different in each
    /// direction; 4 mean edge lengths with `--preset paper`].
    /// With `ball` and `corrected`: radius of the balls [default: 4 mean edge lengths].
    /// With `fit`: radius of the points that are fitted [default: the nearest points decide]
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    pub(crate) radius: Option<Length>,
    /// With `auto` and `fit`: standard deviation of the noise of vertices. The scale of the fits follows it
    /// [default: estimated from the mesh with `auto`, 0 with `fit`]
    #[arg(long, value_name = "LENGTH", value_parser = parse_length, conflicts_with = "radius")]
    pub(crate) noise: Option<Length>,
    /// With `face`: how curvature is computed from the sections
    #[arg(long, value_enum, default_value_t)]
    pub(crate) preset: EstimatorPreset,
    /// With `fit`: quadratic surfaces are fitted to this number of rings of neighbours, with equal weights
    #[arg(long, value_name = "N", conflicts_with_all = ["radius", "noise"], value_parser = |text: &str| parse_count(text, 1..=16))]
    pub(crate) rings: Option<usize>,
    /// With all but `vertex` and `face`: write the coloured mesh, or principal directions as thin diamonds, red for the
    /// larger curvature and blue for the smaller
    #[arg(id = "as", long = "as", value_enum, default_value_t)]
    pub(crate) shown: Shown,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum EstimatorName {
    /// Surfaces fitted at each vertex, at a scale that follows the noise of the mesh. Sums over the mesh come from
    /// `vertex`, except with `--as arrows`
    #[default]
    Auto,
    /// Angles and dihedral angles at each vertex, as in the papers
    Vertex,
    /// Normal sections through each face
    Face,
    /// Surfaces fitted to the nearest points of each vertex
    Fit,
    /// Averages over balls
    Ball,
    /// Averages over balls, with normals interpolated between vertices
    Corrected,
}

/// What the output shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Shown {
    #[default]
    Mesh,
    Arrows,
}

fn quantity() -> impl TypedValueParser<Value = Quantity> {
    let value = |q: &Quantity| PossibleValue::new(q.name()).help(q.meaning());
    PossibleValuesParser::new(Quantity::ALL.iter().map(value))
        .try_map(|name| name.parse::<Quantity>())
}

impl Curvature {
    /// The page of an exhibit with the colours of the quantity, on its vertices or faces.
    pub(crate) fn page(&self, title: &str, on: &str, mut exhibit: Exhibit, scale: &Scale) -> Page {
        set_units(&mut exhibit.fields);
        let mut page = Page::new(format!("{}: {title}", exhibit.name), vec![exhibit]);
        page.start.color = Some(format!("{on}:{}", self.quantity.property()));
        page.start.map = self.colors.colormap;
        page.start.range = Some([scale.low, scale.high]);
        page
    }

    /// Refuses options without effect, and undefined quantities.
    pub(crate) fn check_given(&self, given: &Given) -> Result<(), Failure> {
        self.look.check(&self.job.inputs)?;
        if self.job.output.is_none() && !self.look.is_wanted() {
            given.refuse(&COLOR_OPTIONS, "without -o nothing is coloured")?;
        }
        let estimator = self.estimate.estimator;
        if estimator != EstimatorName::Face {
            given.refuse(&["preset"], "it is for --estimator face")?;
        }
        if estimator != EstimatorName::Fit {
            given.refuse(&["rings"], "it is for --estimator fit")?;
        }
        if !matches!(estimator, EstimatorName::Auto | EstimatorName::Fit) {
            given.refuse(&["noise"], "it is for --estimator auto and fit")?;
        }
        if matches!(estimator, EstimatorName::Auto | EstimatorName::Vertex) {
            given.refuse(&["radius"], "it is for --estimator face, fit, ball and corrected")?;
        } else {
            given.refuse(&["area"], "curvature is found pointwise")?;
            self.check_quantity()?;
        }
        if matches!(estimator, EstimatorName::Vertex | EstimatorName::Face) {
            given.refuse(&["as"], "it is for --estimator auto, fit, ball and corrected")?;
        }
        if self.estimate.shown == Shown::Arrows {
            given.refuse(&COLOR_OPTIONS, "arrows have their own colours")?;
        }
        Ok(())
    }

    /// Refuses a quantity that only the estimator `vertex` has.
    fn check_quantity(&self) -> Result<(), Failure> {
        let quantity = self.quantity;
        if quantity.is_of_star() {
            return Err(Failure::usage(format!(
                "{quantity} is defined by the star of a vertex; use --estimator auto or vertex"
            )));
        }
        Ok(())
    }
}
