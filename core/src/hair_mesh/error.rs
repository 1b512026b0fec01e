//! Why layers are no hair mesh, or why an operation on one is refused: what, where, and what to do.

/// Nothing has changed when an operation returns one of these.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum HairMeshError {
    #[error("layer {layer} has places for {found} bundles and layer 0 for {expected}")]
    BundleCount { layer: usize, found: usize, expected: usize },
    #[error("bundle {bundle} has a face in layer {layer} but none in the layer below")]
    Gap { layer: usize, bundle: usize },
    #[error("the face of bundle {bundle} in layer {layer} has {found} corners; its root face has {expected}")]
    CornerCount { layer: usize, bundle: usize, found: usize, expected: usize },
    #[error("the face of bundle {bundle} in layer {layer} has fewer than three different corners")]
    Degenerate { layer: usize, bundle: usize },
    #[error("the face of bundle {bundle} in layer {layer} names vertex {vertex}, which the layer does not have")]
    Index { layer: usize, bundle: usize, vertex: u32 },
    #[error("vertex {vertex} of layer {layer} stands on two vertices of the layer below: separate it first")]
    ManyToOne { layer: usize, vertex: u32 },
    #[error("vertex {vertex} of layer {layer} is not at a finite place")]
    NotFinite { layer: usize, vertex: u32 },
    #[error("the pinned vertices of layer {layer} are not in rising order")]
    PinnedOrder { layer: usize },

    #[error("nothing is selected: select {needed} first")]
    NothingSelected { needed: &'static str },
    #[error("there is no bundle {bundle}")]
    NoBundle { bundle: usize },
    #[error("there is no vertex {vertex} in layer {layer}")]
    NoVertex { layer: usize, vertex: u32 },
    #[error("no face of layer {layer} has an edge from vertex {a} to vertex {b}")]
    NoEdge { layer: usize, a: u32, b: u32 },
    #[error("bundle {bundle} ends below layer {layer}: choose one of its own layers or extrude it first")]
    NoLayer { layer: usize, bundle: usize },
    #[error("{what} must be between {min} and {max}")]
    OutOfRange { what: &'static str, min: &'static str, max: &'static str },
    #[error("the root layer lies on the scalp and cannot be {done}: choose a layer above it")]
    RootLayer { done: &'static str },
    #[error("{what} has no direction: give one that is longer than nothing")]
    NoDirection { what: &'static str },
    #[error("vertex {vertex} of layer {layer} has only one face: there is nothing to separate it from")]
    VertexOfOneFace { layer: usize, vertex: u32 },
    #[error("the edge {a}-{b} of layer {layer} has only one face: there is nothing to separate it from")]
    EdgeOfOneFace { layer: usize, a: u32, b: u32 },
    #[error(
        "the edge {a}-{b} of layer {layer} holds together around both ends: select a line of edges that \
         passes a vertex or reaches the border, or separate one of its vertices"
    )]
    EdgeStaysClosed { layer: usize, a: u32, b: u32 },
    #[error(
        "vertex {vertex} of layer {layer} stands on a root vertex of its own: only vertices that were \
         separated from each other can be welded"
    )]
    NoTwinVertex { layer: usize, vertex: u32 },
    #[error(
        "no other selected edge stands on the root edge of {a}-{b} in layer {layer}: select the edge on \
         the other side of the parting too"
    )]
    NoTwinEdge { layer: usize, a: u32, b: u32 },
    #[error(
        "bundle {bundle} crosses the middle and its root face is not symmetric: divide it along the middle or \
         move its corners onto it"
    )]
    AcrossTheMiddle { bundle: usize },
    #[error(
        "bundle {bundle} has {n_corners} corners and Loop subdivision takes triangles: divide it first or use Catmull-Clark"
    )]
    NotTriangle { bundle: usize, n_corners: usize },
    #[error(
        "corners {a} and {b} of bundle {bundle} do not divide it: choose two of its {n_corners} corners that are not neighbours"
    )]
    CornersDoNotDivide { bundle: usize, a: usize, b: usize, n_corners: usize },
}
