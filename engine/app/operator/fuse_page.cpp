// The page that aligns an intraoral scan with a CBCT: the user picks the same points in both, checks the registration
// and replaces the crowns.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/app/operator/widgets.h"
#include "engine/base/units.h"

namespace typodont {

using namespace widgets;

namespace {

constexpr std::array kFuseTitles{"op.fuse_scan", "op.fuse_ct"};
constexpr double kFuseZoom = 1.15;  // factor on the picture's scale per wheel step
// Mouse motion, pixels. A longer motion turns the surface; a shorter motion picks a point.
constexpr float kClick = 4;

/// A click picks a point, a drag turns the surface, the wheel zooms.
void follow_mouse_of_fuse(FuseForm& form, ScanFusion::Side side, ImVec2 at, float size) {
  const ImGuiIO& io = ImGui::GetIO();
  SurfacePicture& view = form.fusion->view(side);
  if (ImGui::IsItemHovered() && io.MouseWheel != 0) {
    view.zoom(std::pow(kFuseZoom, static_cast<double>(io.MouseWheel)));
    form.changed = true;
  }
  const auto moved = static_cast<float>(std::hypot(io.MousePos.x - form.pressed.x, io.MousePos.y - form.pressed.y));
  if (ImGui::IsItemActivated()) {
    form.pressed = {io.MousePos.x, io.MousePos.y};
    form.turning = false;
  } else if (ImGui::IsItemActive() && (form.turning || moved > kClick)) {
    form.turning = true;
    if (io.MouseDelta.x != 0 || io.MouseDelta.y != 0) {
      view.turn(dvec2(io.MouseDelta.x, io.MouseDelta.y) / static_cast<double>(size));
      form.changed = true;
    }
  }
  if (ImGui::IsItemDeactivated() && !form.turning) {
    const dvec2 place(static_cast<double>((form.pressed.x - at.x) / size),
                      static_cast<double>((form.pressed.y - at.y) / size));
    if (form.fusion->pick(side, place)) form.changed = true;
  }
}

void draw_surface(OperatorState& s, InterfaceWindow& w, ScanFusion::Side side, float size) {
  FuseForm& form = s.fuse;
  titled_picture(s, w, kFuseTitles[side], form.pictures, side, size, [&](ImVec2 at) {
    if (!s.busy) follow_mouse_of_fuse(form, side, at, size);
    ImDrawList* draw = ImGui::GetWindowDrawList();
    draw->PushClipRect(at, {at.x + size, at.y + size}, true);
    const std::vector<dvec3>& points = form.fusion->points(side);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const dvec2 place = form.fusion->view(side).place_of(points[i]);
      const ImVec2 p{at.x + static_cast<float>(place.x) * size, at.y + static_cast<float>(place.y) * size};
      const float radius = 0.3f * w.style().unit;
      draw->AddCircleFilled(p, radius, IM_COL32(20, 90, 160, 255));
      draw->AddCircle(p, radius, IM_COL32(255, 255, 255, 255), 0, 1.5f);
      const std::string number = std::to_string(i + 1);
      draw->AddText({p.x + radius, p.y - 1.2f * w.style().unit}, IM_COL32(255, 255, 255, 255), number.c_str());
    }
    draw->PopClipRect();
  });
}

void draw_side_of_fuse(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  ScanFusion& fusion = *s.fuse.fusion;
  const PagePanel panel("fuse", s.text("op.fuse"), size, w);
  const std::size_t pairs = std::min(fusion.points(ScanFusion::kScan).size(), fusion.points(ScanFusion::kCt).size());
  row(s.text("op.fuse_pairs"), fmt::format("{} / {}", pairs, ScanFusion::kMinPairs),
      pairs >= ScanFusion::kMinPairs ? &kGood : &kWarn);
  const auto button = [&](const char* text, int code, bool enabled, bool main = false) {
    const std::string label = fmt::format("{}   {}", s.text(text), code);
    return key_button(label, {-1, 0}, enabled && !s.busy, key('0' + code), main);
  };
  if (button("op.fuse_drop", 1, pairs + fusion.points(ScanFusion::kScan).size() > 0)) {
    fusion.drop_last();
    s.fuse.changed = true;
  }
  if (button("op.fuse_register", 2, fusion.can_register() && !fusion.registration(), true)) s.ask(Ask::kFuseRegister);
  if (const auto& found = fusion.registration()) {
    const auto mm = [&](double metres) { return fmt::format("{} mm", s.number(metres / kMillimetre, 3)); };
    ImGui::Spacing();
    row(s.text("op.fuse_clicks"), mm(found->start.fre_rms));
    row(s.text("op.fuse_median"), mm(found->fine.median));
    row(s.text("op.fuse_most"), mm(found->fine.most_of));
    // An uncertainty larger than this is shown as a warning, m.
    constexpr double kFair = 0.1e-3;
    row(s.text("op.fuse_error"), "± " + mm(found->fine.predicted_error),
        found->fine.predicted_error < kFair ? &kGood : &kWarn);
    row(s.text("op.fuse_area"), fmt::format("{} mm²", s.number(found->fine.area / kSquareMillimetre, 0)));
    row(s.text("op.fuse_agreement"), fmt::format("{} %", s.number(100 * found->fine.agreement, 0)));
    ImGui::Spacing();
  }
  if (button("op.fuse_take", 3, fusion.registration().has_value(), true)) s.ask(Ask::kFuseTake);
  if (button("op.fuse_back", 4, true)) s.ask(Ask::kFuseBack);
  ImGui::Spacing();
  note(s.text("op.fuse_help"), w);
}

}  // namespace

void draw_fuse_page(OperatorState& s, InterfaceWindow& w) {
  const float u = w.style().unit;
  const ImVec2 body = begin_titled_page(s.text("op.fuse"), w), gap = ImGui::GetStyle().ItemSpacing;
  if (!s.fuse.fusion) return end_empty_page(s, w, body);
  const float height = body.y, side = std::max(0.26f * body.x, 18 * u);
  const float size = std::min((body.x - side - 3 * gap.x) / 2, height - 1.4f * u - gap.y);
  begin_column("surfaces", {body.x - side - gap.x, height});
  draw_surface(s, w, ScanFusion::kScan, size);
  ImGui::SameLine();
  draw_surface(s, w, ScanFusion::kCt, size);
  ImGui::EndChild();
  ImGui::SameLine();
  draw_side_of_fuse(s, w, {side, height});
  end_titled_page(s, w);
}

}  // namespace typodont
