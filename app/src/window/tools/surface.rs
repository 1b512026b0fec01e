//! The head's surface under the pointer, for every tool that touches it.

use std::sync::Arc;

use egui::Pos2;
use lorelei_core::groom::Head;
use lorelei_core::mesh::TriMesh;
use lorelei_core::mesh_query::{MeshQuery, SurfacePoint};

use super::View;

/// A query over the head, made again where the head is another one.
#[derive(Default)]
pub struct HeadSurface {
    of: Option<(Arc<TriMesh>, Option<Arc<MeshQuery>>)>,
}

impl HeadSurface {
    /// `None` without a head that has faces.
    pub fn query(&mut self, head: Option<&Head>) -> Option<Arc<MeshQuery>> {
        let mesh = &head?.mesh;
        if self.of.as_ref().is_none_or(|(known, _)| !Arc::ptr_eq(known, mesh)) {
            self.of = Some((Arc::clone(mesh), MeshQuery::new(mesh).ok().map(Arc::new)));
        }
        self.of.as_ref()?.1.clone()
    }

    /// Where the ray through a point of the window meets the head, in the head's space.
    pub fn hit(&mut self, head: Option<&Head>, view: &View<'_>, at: Pos2) -> Option<SurfacePoint> {
        let (origin, direction) = view.projection.ray(at);
        self.query(head)?.ray(origin, direction)
    }
}
