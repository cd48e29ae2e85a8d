// The page that shows a scan before its import: three sections with region and labels, tools for corrections, import.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/app/operator/widgets.h"
#include "engine/base/units.h"

namespace typodont {

using namespace widgets;

namespace {

constexpr double kScanZoom = 1.15;  // factor on the width that a section shows, per wheel step
// Largest distance from an edge of the region's box at which the mouse drags this edge, in text heights.
constexpr float kGrip = 0.5f;
constexpr std::array kScanTitles{"op.scan_axial", "op.scan_coronal", "op.scan_sagittal"};
constexpr std::array kTools{"op.scan_look", "op.scan_brush", "op.scan_seed"};
constexpr std::array kKinds{"op.kind_bone", "op.kind_tooth", "op.kind_metal", "op.kind_canal", "op.kind_nothing"};
static_assert(kKinds.size() == haptics::kLabelKinds);

ImU32 color_of(const glm::dvec3& rgb) {
  return IM_COL32(static_cast<int>(rgb.x), static_cast<int>(rgb.y), static_cast<int>(rgb.z), 255);
}

glm::dvec3 kind_color(haptics::LabelKind kind) {
  constexpr std::array kTissues{Tissue::kCorticalBone, Tissue::kDentin, Tissue::kAmalgam, Tissue::kPulp};
  return kind == haptics::LabelKind::kNothing ? glm::dvec3(235) : label_color(kTissues[static_cast<std::size_t>(kind)]);
}

void paint(ScanForm& form, const dvec3& from_F, const dvec3& to_F, bool joins) {
  haptics::LabelStroke stroke;
  stroke.kind = static_cast<haptics::LabelKind>(form.kind);
  stroke.path = {from_F, to_F};
  stroke.radius = static_cast<double>(form.radius_mm) * kMillimetre;
  stroke.only_tissue = form.only_tissue;
  form.change([stroke, joins](ScanReview& review) { review.correct(stroke, joins); });
}

/// Left button: drags an edge or the crosshair, or uses the tool. Right button: moves the crosshair. Wheel: changes the
/// slice; with Ctrl: the width of the shown section.
void follow_mouse_of_scan(OperatorState& s, std::size_t i, const SectionView& view, float grip) {
  ScanForm& form = s.scan;
  const ScanReview& review = *form.review;
  const ImGuiIO& io = ImGui::GetIO();
  const dvec3 p_F = view.point(io.MousePos);
  const auto look_at_mouse = [&] { form.change([p_F](ScanReview& r) { r.look_at(p_F); }); };
  const auto set_dragging = [&](bool dragging) {
    form.change([dragging](ScanReview& r) { r.set_dragging(dragging); });
  };
  const glm::ivec3 near = form.tool == ScanTool::kLook ? review.walls_at(i, p_F, view.length(grip)) : glm::ivec3(0);
  if (ImGui::IsItemHovered()) {
    if (near != glm::ivec3(0)) ImGui::SetMouseCursor(ImGuiMouseCursor_ResizeAll);
    if (io.MouseWheel != 0) {
      const double wheel = static_cast<double>(io.MouseWheel);
      if (io.KeyCtrl)
        form.change([wheel](ScanReview& r) { r.set_width(r.width() * std::pow(kScanZoom, -wheel)); });
      else
        form.change([i, wheel](ScanReview& r) { r.scroll(i, static_cast<int>(std::lround(wheel))); });
    }
    if (ImGui::IsMouseDown(ImGuiMouseButton_Right)) look_at_mouse();
  }
  if (ImGui::IsItemActivated()) {
    form.walls = near;
    set_dragging(near != glm::ivec3(0));
    form.mouse_F = p_F;
    if (form.tool == ScanTool::kBrush && review.can_correct()) paint(form, p_F, p_F, false);
    if (form.tool == ScanTool::kSeed && review.can_correct()) {
      haptics::LabelSeed seed;
      seed.kind = static_cast<haptics::LabelKind>(form.kind);
      seed.point = p_F;
      seed.reach = static_cast<double>(form.reach_mm) * kMillimetre;
      seed.tolerance = static_cast<double>(form.tolerance);
      form.change([seed](ScanReview& r) { r.correct(seed); });
    }
  }
  if (ImGui::IsItemHovered() && ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left) && form.tool == ScanTool::kLook)
    form.large = i;
  const bool moved = io.MouseDelta.x != 0 || io.MouseDelta.y != 0;
  if (ImGui::IsItemActive()) {
    if (form.walls != glm::ivec3(0)) {
      if (moved) form.change([walls = form.walls, p_F](ScanReview& r) { r.move_walls(walls, p_F); });
    } else if (form.tool == ScanTool::kLook) {
      if (moved || ImGui::IsItemActivated()) look_at_mouse();
    } else if (form.tool == ScanTool::kBrush && moved && review.can_correct()) {
      paint(form, form.mouse_F, p_F, true);
      form.mouse_F = p_F;
    }
  }
  if (ImGui::IsItemDeactivated()) {
    set_dragging(false);
    form.walls = glm::ivec3(0);
  }
}

/// Draws the region's box, the crosshair, the brush, and the letters that name the patient's sides.
void draw_marks(OperatorState& s, std::size_t i, const SectionView& view, bool hovered) {
  const ScanForm& form = s.scan;
  const ScanReview& review = *form.review;
  ImDrawList* draw = ImGui::GetWindowDrawList();
  const ImVec2 end{view.at.x + view.size, view.at.y + view.size};
  draw->PushClipRect(view.at, end, true);
  draw->AddRect(view.screen(review.region().lo), view.screen(review.region().hi), ImGui::GetColorU32(kGood), 0, 0, 2);
  const ImVec2 cross = view.screen(review.crosshair());
  constexpr float kGap = 6;  // pixels, gap in the crosshair that keeps the point visible
  const ImU32 line = ImGui::GetColorU32({kWarn.x, kWarn.y, kWarn.z, 0.6f});
  draw->AddLine({view.at.x, cross.y}, {cross.x - kGap, cross.y}, line);
  draw->AddLine({cross.x + kGap, cross.y}, {end.x, cross.y}, line);
  draw->AddLine({cross.x, view.at.y}, {cross.x, cross.y - kGap}, line);
  draw->AddLine({cross.x, cross.y + kGap}, {cross.x, end.y}, line);
  if (hovered && form.tool != ScanTool::kLook) {
    const bool brush = form.tool == ScanTool::kBrush;
    const float radius = view.pixels(static_cast<double>(brush ? form.radius_mm : form.reach_mm) * kMillimetre);
    const ImU32 color = color_of(kind_color(static_cast<haptics::LabelKind>(form.kind)));
    draw->AddCircle(ImGui::GetIO().MousePos, radius, color, 0, brush ? 2.0f : 1.0f);
  }
  const auto [left, right] = review.sides(i);
  const ImU32 text = ImGui::GetColorU32(ImGuiCol_Text);
  const float margin = 0.3f * ImGui::GetTextLineHeight();
  draw->AddText({view.at.x + margin, view.at.y + margin}, text, left.data(), left.data() + left.size());
  draw->AddText({end.x - ImGui::GetTextLineHeight(), view.at.y + margin}, text, right.data(),
                right.data() + right.size());
  draw->PopClipRect();
}

void draw_section_of_scan(OperatorState& s, InterfaceWindow& w, std::size_t i, float size) {
  ScanForm& form = s.scan;
  titled_picture(s, w, kScanTitles[i], form.pictures, i, size, [&](ImVec2 at) {
    const SectionView view{form.planes[i], at, size};
    const bool hovered = ImGui::IsItemHovered();
    follow_mouse_of_scan(s, i, view, kGrip * w.style().unit);
    draw_marks(s, i, view, hovered);
  });
}

/// Draws number fields for the faces of the region's box, in mm from the first voxel of the scan.
void edit_region(ScanForm& form) {
  const dvec3 origin = form.review->scan()->lo();
  haptics::ImportRegion region = form.review->region();
  constexpr std::array kAxes{"x", "y", "z"};
  for (int a = 0; a < 3; ++a) {
    std::array<double, 2> mm{(region.lo[a] - origin[a]) / kMillimetre, (region.hi[a] - origin[a]) / kMillimetre};
    ImGui::PushID(a);
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(kAxes[static_cast<std::size_t>(a)]);
    ImGui::SameLine();
    ImGui::SetNextItemWidth(-1);
    if (ImGui::InputScalarN("##walls", ImGuiDataType_Double, mm.data(), 2, nullptr, nullptr, "%.1f mm",
                            ImGuiInputTextFlags_EnterReturnsTrue)) {
      region.lo[a] = origin[a] + mm[0] * kMillimetre;
      region.hi[a] = origin[a] + mm[1] * kMillimetre;
      form.change([region](ScanReview& review) {
        review.set_region(region);
        review.want_full();
      });
    }
    ImGui::PopID();
  }
}

void draw_tools(OperatorState& s) {
  ScanForm& form = s.scan;
  const ScanReview& review = *form.review;
  const float gap = ImGui::GetStyle().ItemSpacing.x, third = (ImGui::GetContentRegionAvail().x - 2 * gap) / 3;
  for (std::size_t i = 0; i < kTools.size(); ++i) {
    if (i > 0) ImGui::SameLine();
    const bool on = form.tool == static_cast<ScanTool>(i);
    if (toggle_button(fmt::format("{} {}", s.text(kTools[i]), i + 1).c_str(), on, {third, 0}) ||
        key('1' + static_cast<int>(i)))
      form.tool = static_cast<ScanTool>(i);
  }
  if (form.tool == ScanTool::kLook) return;
  std::array<const char*, kKinds.size()> names{};
  std::ranges::transform(kKinds, names.begin(), [&](const char* key) { return s.text(key); });
  choice("##kind", form.kind, names);
  if (form.tool == ScanTool::kBrush) {
    slider(s, "##radius", form.radius_mm, 0.3f, 8, s.text("op.radius"), 1, " mm");
    const bool removes = static_cast<haptics::LabelKind>(form.kind) == haptics::LabelKind::kNothing;
    ImGui::BeginDisabled(removes);
    ImGui::Checkbox(s.text("op.scan_only_tissue"), &form.only_tissue);
    ImGui::EndDisabled();
  } else {
    slider(s, "##reach", form.reach_mm, 1, 20, s.text("op.scan_reach"), 0, " mm");
    slider(s, "##tolerance", form.tolerance, 0.05f, 1, s.text("op.scan_tolerance"), 2);
  }
  if (!review.can_correct()) dim_wrapped(s.text("op.scan_needs_full"));
  const float half = 0.5f * (ImGui::GetContentRegionAvail().x - gap);
  if (key_button(s.text("op.undo"), {half, 0}, review.can_undo(), false)) form.change(&ScanReview::undo);
  ImGui::SameLine();
  if (key_button(s.text("op.redo"), {half, 0}, review.can_redo(), false)) form.change(&ScanReview::redo);
}

void draw_volumes(OperatorState& s) {
  const ScanReview& review = *s.scan.review;
  const char* state = review.current() && review.detail() == LabelDetail::kFull     ? "op.scan_full"
                      : review.current() && review.detail() == LabelDetail::kCoarse ? "op.scan_coarse"
                                                                                    : "op.scan_none";
  dim(s.text(state));
  if (!review.labels()) return;
  ImDrawList* draw = ImGui::GetWindowDrawList();
  for (std::size_t t = 1; t < review.volumes().size(); ++t) {
    const double mm3 = review.volumes()[t] / kCubicMillimetre;
    if (!(mm3 >= 0.05)) continue;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float height = ImGui::GetTextLineHeight(), side = 0.6f * height, down = 0.5f * (height - side);
    draw->AddRectFilled({at.x, at.y + down}, {at.x + side, at.y + down + side},
                        color_of(label_color(static_cast<Tissue>(t))));
    ImGui::Indent(height);
    row(s.text(fmt::format("tissue.{}", name_of(static_cast<Tissue>(t)))), fmt::format("{} mm³", s.number(mm3, 1)));
    ImGui::Unindent(height);
  }
}

void draw_side_of_scan(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  ScanForm& form = s.scan;
  const ScanReview& review = *form.review;
  const PagePanel panel("scan", s.text("op.scan"), size, w);
  // The preset "arch" is missing, because it is for intraoral scans, which are meshes; meshes have their own form.
  constexpr std::array kPresets{haptics::ImportPreset::kTooth, haptics::ImportPreset::kBone,
                                haptics::ImportPreset::kJaw};
  const std::array names{s.text("op.preset_tooth"), s.text("op.preset_bone"), s.text("op.preset_jaw")};
  int preset = static_cast<int>(std::ranges::find(kPresets, review.preset()) - kPresets.begin());
  if (choice("##preset", preset, names)) {
    const haptics::ImportPreset wanted = kPresets[static_cast<std::size_t>(preset)];
    form.change([wanted](ScanReview& r) { r.set_preset(wanted); });
    s.import.preset = static_cast<int>(wanted);
  }
  dim(s.text("op.scan_region"));
  edit_region(form);
  auto width = static_cast<float>(review.width() / kMillimetre);
  if (slider(s, "##width", width, 10, static_cast<float>(review.whole_width() / kMillimetre), s.text("op.plan_width"),
             0, " mm"))
    form.change([width](ScanReview& r) { r.set_width(static_cast<double>(width) * kMillimetre); });
  const bool full = review.can_correct();
  if (key_button(fmt::format("{}   4", s.text("op.scan_label")), {-1, 0}, !s.busy && !full, key('4')))
    form.change(&ScanReview::want_full);
  ImGui::Spacing();
  draw_tools(s);
  ImGui::Spacing();
  draw_volumes(s);
  ImGui::Spacing();
  file_field("mesh", s.text("op.fuse_file"), s.fuse.file, s.fuse.chooser, haptics::mesh_endings(), s, w);
  const bool can_fuse = !s.busy && full && s.fuse.file[0] != 0;
  if (key_button(fmt::format("{}   5", s.text("op.fuse_open")), {-1, 0}, can_fuse, key('5'))) s.ask(Ask::kFuse);
  ImGui::Spacing();
  note(s.text("op.scan_mouse"), w);
  if (key('Z', true)) form.change(&ScanReview::undo);
  if (key('Y', true)) form.change(&ScanReview::redo);
}

void draw_import(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("import", s.text("op.exercise"), size, w);
  text_field("##name", s.text("op.import_name"), s.import.name);
  const std::array crowns = {s.text("op.crown_up"),   s.text("op.crown_down"), s.text("op.crown_right"),
                             s.text("op.crown_left"), s.text("op.crown_back"), s.text("op.crown_front")};
  choice("##crown", s.import.crown, crowns);
  ask_button(s, Ask::kImport, s.text("op.import_do"), {-1, 0}, !s.busy && s.import.name[0] != 0, true);
}

}  // namespace

void draw_scan_page(OperatorState& s, InterfaceWindow& w) {
  const float u = w.style().unit;
  const ImVec2 body = begin_titled_page(s.text("op.scan"), w), gap = ImGui::GetStyle().ItemSpacing;
  if (!s.scan.review) return end_empty_page(s, w, body);
  // Arranges three square sections: a large one, and two smaller ones beside it.
  const float height = body.y, side = std::max(0.28f * body.x, 20 * u), lower = 8.8f * u;
  const float caption = 1.4f * u + gap.y, small = 0.5f * (height - 2 * caption - gap.y);
  const float large = std::min(height - caption, body.x - side - small - 3 * gap.x);
  const std::size_t first = s.scan.large, second = (first + 1) % kScanSections, third = (first + 2) % kScanSections;
  begin_column("sections", {body.x - side - gap.x, height});
  draw_section_of_scan(s, w, first, large);
  ImGui::SameLine();
  ImGui::BeginGroup();
  draw_section_of_scan(s, w, second, small);
  draw_section_of_scan(s, w, third, small);
  ImGui::EndGroup();
  ImGui::EndChild();
  ImGui::SameLine();
  begin_column("side", {side, height});
  draw_side_of_scan(s, w, {0, height - lower - gap.y});
  draw_import(s, w, {0, lower});
  ImGui::EndChild();
  end_titled_page(s, w);
}

}  // namespace typodont
