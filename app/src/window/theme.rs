//! The studio's colours, spacing and type: neutral greys, so that hair colours can be judged, one accent.
//!
//! The viewport's surround is darker than the panels, and no grey carries a hue. Brightness says what a
//! thing is: background, panel, field, control, control under the pointer. The accent marks what is
//! selected, changed or running, and nothing else.

use egui::{Color32, CornerRadius, FontFamily, FontId, Margin, Shadow, Stroke, TextStyle, Vec2, Visuals};

/// Between panels.
pub const GAP: Color32 = Color32::from_gray(20);
pub const PANEL: Color32 = Color32::from_gray(38);
pub const HEADER: Color32 = Color32::from_gray(29);
/// Where text and numbers are typed.
pub const FIELD: Color32 = Color32::from_gray(24);
pub const CONTROL: Color32 = Color32::from_gray(56);
pub const CONTROL_HOVER: Color32 = Color32::from_gray(70);
pub const CONTROL_ACTIVE: Color32 = Color32::from_gray(84);
pub const LINE: Color32 = Color32::from_gray(50);
pub const TEXT: Color32 = Color32::from_gray(205);
pub const TEXT_STRONG: Color32 = Color32::from_gray(240);
pub const TEXT_WEAK: Color32 = Color32::from_gray(138);
pub const ACCENT: Color32 = Color32::from_rgb(222, 168, 82);
pub const ACCENT_DIM: Color32 = Color32::from_rgb(105, 82, 46);
/// Pins in the viewport: no hair has this colour, and nothing else there.
pub const PIN: Color32 = Color32::from_rgb(104, 200, 216);
pub const ERROR: Color32 = Color32::from_rgb(226, 108, 92);
pub const GOOD: Color32 = Color32::from_rgb(128, 184, 124);

/// Height of a row in lists and forms.
pub const ROW: f32 = 22.0;

/// Colours for things that are told apart by colour: passes in a plot.
pub const SERIES: [Color32; 8] = [
    Color32::from_rgb(222, 168, 82),
    Color32::from_rgb(110, 160, 205),
    Color32::from_rgb(128, 184, 124),
    Color32::from_rgb(200, 120, 120),
    Color32::from_rgb(168, 140, 200),
    Color32::from_rgb(120, 190, 190),
    Color32::from_rgb(205, 150, 180),
    Color32::from_rgb(160, 160, 160),
];

/// Set colours, spacing and type for the whole window.
pub fn install(ctx: &egui::Context) {
    ctx.set_theme(egui::Theme::Dark);
    ctx.all_styles_mut(|style| {
        style.visuals = visuals();
        style.text_styles = [
            (TextStyle::Small, FontId::new(11.0, FontFamily::Proportional)),
            (TextStyle::Body, FontId::new(13.0, FontFamily::Proportional)),
            (TextStyle::Button, FontId::new(13.0, FontFamily::Proportional)),
            (TextStyle::Heading, FontId::new(15.0, FontFamily::Proportional)),
            (TextStyle::Monospace, FontId::new(12.0, FontFamily::Monospace)),
        ]
        .into();
        let spacing = &mut style.spacing;
        spacing.item_spacing = Vec2::new(6.0, 4.0);
        spacing.button_padding = Vec2::new(8.0, 3.0);
        spacing.interact_size = Vec2::new(28.0, ROW);
        spacing.menu_margin = Margin::same(6);
        spacing.window_margin = Margin::same(12);
        spacing.indent = 8.0;
        spacing.icon_width = 16.0;
        spacing.combo_width = 80.0;
        spacing.tooltip_width = 320.0;
        spacing.scroll = egui::style::ScrollStyle::thin();
        style.interaction.tooltip_delay = 0.35;
        style.interaction.selectable_labels = false;
    });
}

fn visuals() -> Visuals {
    let mut v = Visuals::dark();
    let radius = CornerRadius::same(3);
    v.override_text_color = None;
    v.weak_text_color = Some(TEXT_WEAK);
    v.panel_fill = PANEL;
    v.window_fill = Color32::from_gray(34);
    v.window_stroke = Stroke::new(1.0, Color32::from_gray(62));
    v.window_corner_radius = CornerRadius::same(6);
    v.menu_corner_radius = CornerRadius::same(5);
    v.window_shadow = Shadow { offset: [0, 8], blur: 24, spread: 0, color: Color32::from_black_alpha(140) };
    v.popup_shadow = Shadow { offset: [0, 4], blur: 12, spread: 0, color: Color32::from_black_alpha(120) };
    v.extreme_bg_color = FIELD;
    v.faint_bg_color = Color32::from_gray(43);
    v.code_bg_color = Color32::from_gray(30);
    v.hyperlink_color = ACCENT;
    v.warn_fg_color = ACCENT;
    v.error_fg_color = ERROR;
    v.selection.bg_fill = ACCENT_DIM;
    v.selection.stroke = Stroke::new(1.0, TEXT_STRONG);
    v.slider_trailing_fill = true;
    v.indent_has_left_vline = false;
    for (widget, fill, text) in [
        (&mut v.widgets.inactive, CONTROL, TEXT),
        (&mut v.widgets.hovered, CONTROL_HOVER, TEXT_STRONG),
        (&mut v.widgets.active, CONTROL_ACTIVE, TEXT_STRONG),
        (&mut v.widgets.open, CONTROL_HOVER, TEXT_STRONG),
    ] {
        widget.bg_fill = fill;
        widget.weak_bg_fill = fill;
        widget.bg_stroke = Stroke::NONE;
        widget.fg_stroke = Stroke::new(1.0, text);
        widget.corner_radius = radius;
        widget.expansion = 0.0;
    }
    let still = &mut v.widgets.noninteractive;
    still.bg_fill = PANEL;
    still.weak_bg_fill = PANEL;
    still.bg_stroke = Stroke::new(1.0, LINE);
    still.fg_stroke = Stroke::new(1.0, TEXT);
    still.corner_radius = radius;
    v
}
