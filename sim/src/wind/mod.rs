//! The air around a groom on a grid: what the solver's strands are blown by when the wind is `grid`.
//!
//! A semi-Lagrangian solver (Stam 1999, "Stable fluids") with speeds on the faces of cubes (Harlow and Welch 1965).
//! Once a frame, whatever number of steps the strands take in it, for the air changes less in a frame than the strands do:
//!
//! 1. [`hair`]: guides leave their hair's length and momentum in the cells around them.
//! 2. [`predict`]: the air is carried along its own path, its eddies are driven (Fedkiw et al. 2001), hair, head and
//!    sources pull at it, each as if with its speed at the end of the step.
//! 3. [`pressure`]: multigrid finds the pressure that leaves no divergence, and it pushes.
//!
//! **One equation for all that stands in the way.** Hair is a porous body: its pull is in the equation of the pressure
//! too, so that wind goes through hair as far as the pressure drives it. A wall is the limit of this, with the share of
//! each face that is open (after Batty et al. 2007). So what is stored is the flux through whole faces, its
//! divergence is the residual of the pressure, and the air that touches the head is slowed by it as by a rough wall.
//!
//! **The box** stands upright in the world and follows the head, by whole cells. In the head's own frame, every turn of the
//! head would blow on the hair from all sides through a boundary that moves; fixed in the world, a head that walks leaves
//! it. By whole cells, a box that moves changes no number in it. Beyond the box is [`free`] air: through the
//! boundary comes in what blows there, the steady wind with its gusts and eddies and the streams of sources outside, at its own
//! speed; everywhere else on the boundary the pressure is 0.
//!
//! Plain advection, not MacCormack's: at 300 cm/s air crosses four cells of 1.3 cm in a frame, where the corrector's
//! limiter takes back most of what it adds, and the confinement returns the eddies at a tenth of the reads.

pub mod air;
pub mod cpu;
pub mod free;
pub mod gpu;
pub mod grid;
pub mod hair;
pub mod predict;
pub mod pressure;

pub use air::AirGrid;
pub use cpu::CpuWind;
pub use free::FreeAir;
pub use gpu::GpuWind;
pub(crate) use grid::ROOM;
pub use grid::WindFrame;
