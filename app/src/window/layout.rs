//! Which panels there are, where they are at first, and how their tabs look.

use egui::{Color32, CornerRadius, Margin, Stroke, Vec2, WidgetText};
use egui_tiles::{
    Container, Linear, LinearDir, SimplificationOptions, TabState, Tile, TileId, Tiles, Tree, UiResponse,
};
use serde::{Deserialize, Serialize};

use super::desk::Desk;
use super::panels;
use super::theme;
use super::viewport::Viewport;

/// A panel that can be moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Panel {
    Viewport,
    Outliner,
    Properties,
    Tool,
    Look,
    Lights,
    Simulation,
    Statistics,
    Levels,
    History,
}

impl Panel {
    pub const ALL: [Self; 10] = [
        Self::Viewport,
        Self::Outliner,
        Self::Properties,
        Self::Tool,
        Self::Look,
        Self::Lights,
        Self::Simulation,
        Self::Statistics,
        Self::Levels,
        Self::History,
    ];

    pub fn title(self) -> &'static str {
        match self {
            Self::Viewport => "Viewport",
            Self::Outliner => "Outliner",
            Self::Properties => "Properties",
            Self::Tool => "Tool",
            Self::Look => "Look",
            Self::Lights => "Lights",
            Self::Simulation => "Movement",
            Self::Statistics => "Statistics",
            Self::Levels => "Levels",
            Self::History => "History",
        }
    }
}

/// Outliner and properties at the left, the viewport in the middle, look, lights and numbers at the right.
pub fn default_layout() -> Tree<Panel> {
    let mut tiles = Tiles::default();
    let mut column = |groups: &[&[Panel]], shares: &[f32]| {
        let mut children = Vec::new();
        for group in groups {
            let panes = group.iter().map(|panel| tiles.insert_pane(*panel)).collect();
            children.push(tiles.insert_tab_tile(panes));
        }
        let mut linear = Linear::new(LinearDir::Vertical, children.clone());
        for (child, share) in children.iter().zip(shares) {
            linear.shares.set_share(*child, *share);
        }
        tiles.insert_container(Container::Linear(linear))
    };
    let left = column(&[&[Panel::Outliner], &[Panel::Properties, Panel::Tool]], &[0.4, 0.6]);
    let right = column(
        &[&[Panel::Look, Panel::Lights, Panel::Simulation], &[Panel::Statistics, Panel::Levels, Panel::History]],
        &[0.64, 0.36],
    );
    let viewport = tiles.insert_pane(Panel::Viewport);
    let mut all = Linear::new(LinearDir::Horizontal, vec![left, viewport, right]);
    for (child, share) in [(left, 0.23), (viewport, 0.52), (right, 0.25)] {
        all.shares.set_share(child, share);
    }
    let root = tiles.insert_container(Container::Linear(all));
    Tree::new(egui::Id::unique("panels"), root, tiles)
}

/// A stored layout may lack a panel (an older version, a damaged file): then it is not used.
pub fn is_complete(layout: &Tree<Panel>) -> bool {
    Panel::ALL.iter().all(|panel| layout.tiles.find_pane(panel).is_some_and(|id| layout.tiles.is_visible(id)))
}

/// Bring a panel to the front of its tabs.
pub fn show(layout: &mut Tree<Panel>, wanted: Panel) {
    layout.make_active(|_, tile| matches!(tile, Tile::Pane(panel) if *panel == wanted));
}

/// Draws the panels.
pub struct Behavior<'a> {
    pub desk: &'a mut Desk,
    pub viewport: &'a mut Viewport,
}

impl egui_tiles::Behavior<Panel> for Behavior<'_> {
    fn pane_ui(&mut self, ui: &mut egui::Ui, _tile_id: TileId, panel: &mut Panel) -> UiResponse {
        if *panel == Panel::Viewport {
            self.viewport.ui(ui, self.desk);
            return UiResponse::None;
        }
        let fill = ui.visuals().panel_fill;
        ui.painter().rect_filled(ui.max_rect(), 0.0, fill);
        egui::Frame::new().inner_margin(Margin { left: 10, right: 4, top: 8, bottom: 4 }).show(ui, |ui| {
            egui::ScrollArea::vertical().id_salt(panel.title()).auto_shrink([false, false]).show(ui, |ui| {
                egui::Frame::new().inner_margin(Margin { left: 0, right: 8, top: 0, bottom: 8 }).show(ui, |ui| {
                    match panel {
                        Panel::Viewport => {}
                        Panel::Outliner => panels::outliner::ui(ui, self.desk),
                        Panel::Properties => panels::properties::ui(ui, self.desk),
                        Panel::Tool => super::tools::panel(ui, self.desk),
                        Panel::Look => panels::look::ui(ui, self.desk),
                        Panel::Lights => panels::lights::ui(ui, self.desk),
                        Panel::Simulation => panels::simulation::ui(ui, self.desk),
                        Panel::Statistics => panels::statistics::ui(ui, self.desk),
                        Panel::Levels => panels::lod::ui(ui, self.desk),
                        Panel::History => panels::history::ui(ui, self.desk),
                    }
                });
            });
        });
        UiResponse::None
    }

    fn on_tab_button(&mut self, tiles: &mut Tiles<Panel>, tile_id: TileId, button: egui::Response) -> egui::Response {
        if let Some(Tile::Pane(panel)) = tiles.get(tile_id) {
            super::state_report::mark(&button.ctx, || format!("tab {}", panel.title()), button.rect);
        }
        button.on_hover_text("Drag it to move the panel")
    }

    fn tab_title_for_pane(&mut self, panel: &Panel) -> WidgetText {
        panel.title().into()
    }

    fn simplification_options(&self) -> SimplificationOptions {
        // A panel alone in its place keeps its tab: by the tab it is moved.
        SimplificationOptions { prune_single_child_tabs: false, ..SimplificationOptions::default() }
    }

    fn is_tab_bar_visible(&self, _tile_id: TileId, _tabs: &egui_tiles::Tabs) -> bool {
        true
    }

    fn tab_bar_height(&self, _style: &egui::Style) -> f32 {
        26.0
    }

    fn gap_width(&self, _style: &egui::Style) -> f32 {
        3.0
    }

    fn min_size(&self) -> f32 {
        120.0
    }

    fn tab_bar_color(&self, _visuals: &egui::Visuals) -> Color32 {
        theme::HEADER
    }

    fn tab_bg_color(
        &self,
        _visuals: &egui::Visuals,
        _tiles: &Tiles<Panel>,
        _tile_id: TileId,
        state: &TabState,
    ) -> Color32 {
        if state.active { theme::PANEL } else { Color32::TRANSPARENT }
    }

    fn tab_outline_stroke(
        &self,
        _visuals: &egui::Visuals,
        _tiles: &Tiles<Panel>,
        _tile_id: TileId,
        _state: &TabState,
    ) -> Stroke {
        Stroke::NONE
    }

    fn tab_bar_hline_stroke(&self, _visuals: &egui::Visuals) -> Stroke {
        Stroke::NONE
    }

    fn tab_text_color(
        &self,
        _visuals: &egui::Visuals,
        _tiles: &Tiles<Panel>,
        _tile_id: TileId,
        state: &TabState,
    ) -> Color32 {
        if state.active { theme::TEXT_STRONG } else { theme::TEXT_WEAK }
    }

    fn resize_stroke(&self, _style: &egui::Style, state: egui_tiles::ResizeState) -> Stroke {
        match state {
            egui_tiles::ResizeState::Idle => Stroke::new(3.0, theme::GAP),
            egui_tiles::ResizeState::Hovering => Stroke::new(3.0, Color32::from_gray(80)),
            egui_tiles::ResizeState::Dragging => Stroke::new(3.0, theme::ACCENT),
        }
    }

    fn is_tile_draggable(&self, tiles: &Tiles<Panel>, tile_id: TileId) -> bool {
        !matches!(tiles.get(tile_id), Some(Tile::Pane(Panel::Viewport)))
    }

    fn paint_drag_preview(
        &self,
        _visuals: &egui::Visuals,
        painter: &egui::Painter,
        _dragged_rect: Option<egui::Rect>,
        preview_rect: egui::Rect,
    ) {
        painter.rect(
            preview_rect.shrink(2.0),
            CornerRadius::same(4),
            theme::ACCENT.gamma_multiply(0.15),
            Stroke::new(1.5, theme::ACCENT),
            egui::StrokeKind::Inside,
        );
    }

    fn ideal_tile_aspect_ratio(&self) -> f32 {
        let Vec2 { x, y } = Vec2::new(4.0, 3.0);
        x / y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_layout_has_every_panel() {
        assert!(is_complete(&default_layout()));
        let text = ron::to_string(&default_layout()).unwrap();
        let back: Tree<Panel> = ron::from_str(&text).unwrap();
        assert!(is_complete(&back));
    }
}
