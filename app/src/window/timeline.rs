//! The timeline below the viewport: play, step, and a ruler to scrub on. What is kept is drawn on it, so that a
//! person sees where going back costs nothing.

use egui::{Align2, Color32, CornerRadius, Painter, Rect, RichText, Sense, Stroke, Ui, pos2, vec2};
use lorelei_core::motion::Movement;

use super::commands::Command;
use super::desk::Desk;
use super::state_report::mark;
use super::theme;

/// Slower than this share of real time is said.
const SLOW: f32 = 0.9;

pub fn ui(ui: &mut Ui, desk: &mut Desk) {
    let frame = egui::Frame::new().fill(theme::HEADER).inner_margin(egui::Margin::symmetric(10, 3));
    egui::Panel::bottom("timeline").frame(frame).show_separator_line(false).show(ui, |ui| {
        ui.horizontal(|ui| {
            transport(ui, desk);
            let movement = desk.document.groom.movement.bounded();
            let words = words(desk, &movement);
            let width = ui.available_width() - 190.0;
            ruler(ui, desk, &movement, width);
            let is_slow = desk.playback.is_playing && desk.report.timeline.speed < SLOW;
            let colour = if is_slow { theme::ACCENT } else { theme::TEXT_WEAK };
            let response = ui.label(RichText::new(words).small().color(colour));
            mark(ui.ctx(), || "timeline words".to_owned(), response.rect);
            response.on_hover_text(if is_slow {
                "The device takes longer than the time it shows: movement is slowed down. Fewer strands, a draft quality or a simulated range help"
            } else {
                "Frame and time on the timeline"
            });
        });
    });
}

/// Frame and time, and what is to be said about them.
fn words(desk: &Desk, movement: &Movement) -> String {
    let timeline = &desk.report.timeline;
    let mut at = format!("{} / {}   {:.2} s", timeline.at, movement.end, timeline.secs);
    if timeline.is_by_hand {
        at += "   by hand";
    }
    if let Some(wanted) = timeline.wanted {
        return format!("{at}   to {wanted}\u{2026}");
    }
    if desk.playback.is_playing && timeline.speed < SLOW {
        return format!("{at}   {:.0} % speed", 100.0 * timeline.speed);
    }
    at
}

/// What a button of the transport shows; the font has no such signs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Sign {
    Start,
    Back,
    Play,
    Pause,
    Forward,
    End,
}

impl Sign {
    fn paint(self, painter: &Painter, rect: Rect, colour: Color32) {
        let c = rect.center();
        let arrow = |x: f32, to_right: bool| {
            let tip = if to_right { 4.0 } else { -4.0 };
            let points = vec![c + vec2(x + tip, 0.0), c + vec2(x - tip, -5.0), c + vec2(x - tip, 5.0)];
            painter.add(egui::Shape::convex_polygon(points, colour, Stroke::NONE));
        };
        let bar = |x: f32| {
            painter.rect_filled(Rect::from_center_size(c + vec2(x, 0.0), vec2(2.0, 10.0)), CornerRadius::ZERO, colour);
        };
        match self {
            Self::Start => {
                bar(-6.0);
                arrow(-1.0, false);
                arrow(5.0, false);
            }
            Self::Back => {
                arrow(-2.0, false);
                bar(5.0);
            }
            Self::Play => arrow(0.0, true),
            Self::Pause => {
                bar(-3.0);
                bar(3.0);
            }
            Self::Forward => {
                bar(-5.0);
                arrow(2.0, true);
            }
            Self::End => {
                arrow(-5.0, true);
                arrow(1.0, true);
                bar(6.0);
            }
        }
    }
}

fn transport(ui: &mut Ui, desk: &mut Desk) {
    let is_playing = desk.playback.is_playing;
    for (sign, command, is_on) in [
        (Sign::Start, Command::ToStart, false),
        (Sign::Back, Command::StepBack, false),
        (if is_playing { Sign::Pause } else { Sign::Play }, Command::Play, is_playing),
        (Sign::Forward, Command::Step, false),
        (Sign::End, Command::ToEnd, false),
    ] {
        let fill = if is_on { theme::ACCENT_DIM } else { theme::CONTROL };
        let row = command.row();
        let shortcut = row.shortcuts.first().map(|s| ui.ctx().format_shortcut(s)).unwrap_or_default();
        let response = ui.add(egui::Button::new("").fill(fill).min_size(vec2(28.0, 22.0)));
        sign.paint(ui.painter(), response.rect, theme::TEXT_STRONG);
        mark(ui.ctx(), || format!("transport {}", row.label), response.rect);
        if response.on_hover_text(format!("{}. {} ({shortcut})", row.label, row.help)).clicked() {
            desk.asked.push(command);
        }
    }
}

/// Frames of a labelled step, so that labels are some sixty points apart.
fn label_step(frames_per_point: f32) -> u32 {
    let least = 60.0 * frames_per_point;
    let tens = 10_f32.powf(least.max(1.0).log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|of| of * tens).find(|step| *step >= least).unwrap_or(10.0 * tens) as u32
}

/// The ruler; pressing and dragging on it shows the frame below the pointer.
fn ruler(ui: &mut Ui, desk: &mut Desk, movement: &Movement, width: f32) {
    let (rect, response) = ui.allocate_exact_size(vec2(width.max(60.0), 24.0), Sense::click_and_drag());
    mark(ui.ctx(), || "timeline ruler".to_owned(), rect);
    let (first, last) = (movement.start as f32, movement.end as f32);
    let track = rect.shrink2(vec2(8.0, 0.0));
    let x_of = |frame: f32| track.left() + track.width() * ((frame - first) / (last - first)).clamp(0.0, 1.0);
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, CornerRadius::same(3), theme::CONTROL);
    let timeline = &desk.report.timeline;
    for [from, to] in &timeline.kept {
        let run =
            Rect::from_x_y_ranges(x_of(*from as f32)..=x_of(*to as f32 + 1.0), rect.bottom() - 4.0..=rect.bottom());
        painter.rect_filled(run, CornerRadius::ZERO, theme::ACCENT_DIM);
    }
    let step = label_step((last - first) / track.width());
    let font = egui::FontId::proportional(9.0);
    let mut label = movement.start.next_multiple_of(step);
    while label <= movement.end {
        let x = x_of(label as f32);
        painter.line_segment([pos2(x, rect.top()), pos2(x, rect.top() + 5.0)], Stroke::new(1.0, theme::TEXT_WEAK));
        // The last one would reach out of the ruler.
        let (by, align) = if x > rect.right() - 26.0 { (-3.0, Align2::RIGHT_TOP) } else { (3.0, Align2::LEFT_TOP) };
        painter.text(pos2(x + by, rect.top() + 1.0), align, label, font.clone(), theme::TEXT_WEAK);
        label += step;
    }
    let at = x_of(timeline.at as f32);
    painter.line_segment([pos2(at, rect.top()), pos2(at, rect.bottom())], Stroke::new(2.0, theme::ACCENT));
    painter.circle_filled(pos2(at, rect.bottom() - 6.0), 4.0, theme::ACCENT);
    if let Some(wanted) = timeline.wanted {
        let x = x_of(wanted as f32);
        painter.line_segment([pos2(x, rect.top()), pos2(x, rect.bottom())], Stroke::new(1.0, Color32::from_gray(200)));
    }
    if (response.dragged() || response.clicked() || response.drag_started())
        && let Some(pointer) = response.interact_pointer_pos()
    {
        let share = ((pointer.x - track.left()) / track.width()).clamp(0.0, 1.0);
        let frame_idx = (first + share * (last - first)).round() as u32;
        if desk.playback.seek != frame_idx
            || desk.playback.is_playing
            || timeline.at != frame_idx && timeline.wanted.is_none()
        {
            desk.seek(frame_idx);
        }
    }
    response
        .on_hover_text("Drag to go through time. The bright line below: frames that are kept, shown again at no cost");
}

/// For the state report.
pub fn report(desk: &Desk) -> serde_json::Value {
    let (timeline, movement) = (&desk.report.timeline, &desk.document.groom.movement);
    serde_json::json!({
        "at": timeline.at,
        "wanted": timeline.wanted,
        "kept": timeline.kept,
        "by_hand": timeline.is_by_hand,
        "motion": format!("{:?}", movement.motion),
        "range": [movement.start, movement.end],
        "fps": movement.fps,
        "node": movement.track.as_ref().map(|track| track.name.as_str()),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_round_numbers_far_enough_apart() {
        for frames_per_point in [0.01, 0.1, 0.7, 3.0, 100.0] {
            let step = label_step(frames_per_point);
            assert!(step as f32 >= 60.0 * frames_per_point && step >= 1, "{frames_per_point}: {step}");
            let digit = step / 10_u32.pow(step.ilog10());
            assert!([1, 2, 5].contains(&digit), "{step}");
        }
    }
}
