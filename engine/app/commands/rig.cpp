// `typodont rig plan`: plans a mirror bench before it is built, as a drawing and an initial rig file.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "engine/app/commands/bench_drawing.h"
#include "engine/app/commands/command_line.h"
#include "engine/app/commands/commands.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/log.h"
#include "engine/base/units.h"

namespace typodont {

namespace {

using display::BenchPlan;
using display::BenchSpec;
using Value = nlohmann::ordered_json;

/// Workspace of an arm, from the manufacturer's data sheet. For a cylinder: the largest box inside it.
struct ArmReach {
  const char* name;
  dvec3 box_mm;  // mm: width, depth, height of the workspace
};
constexpr double kInCircle = 0.7071067811865476;
const std::array<ArmReach, 7> kArms{{{"touch", {160, 70, 120}},
                                     {"touch_x", {160, 120, 120}},
                                     {"falcon", {102, 102, 102}},
                                     {"omega", {160 * kInCircle, 110, 160 * kInCircle}},
                                     {"sigma", {190 * kInCircle, 130, 190 * kInCircle}},
                                     {"lambda", {240 * kInCircle, 170, 240 * kInCircle}},
                                     {"delta", {400 * kInCircle, 260, 400 * kInCircle}}}};

struct RigOptions {
  std::vector<double> panel_mm{531, 299};
  std::vector<int> pixels{1920, 1080};
  std::string layout = "side_by_side", arm = "touch";
  std::vector<double> arm_box_mm, work_mm{6.8, 6.5, 17};
  double mirror_deg = 0, picture_deg = 20, gaze_deg = 52, eye_mm = 520, ipd_mm = 63, glass_mm = 150;
  double hand_mm = 40, comfort = 0.3;
  std::string out, rig;
  bool json = false;
};

BenchSpec spec_of(const RigOptions& options) {
  BenchSpec spec;
  spec.panel_width = options.panel_mm[0] * kMillimetre, spec.panel_height = options.panel_mm[1] * kMillimetre;
  if (!(spec.panel_width >= 0.05 && spec.panel_width <= 3 && spec.panel_height >= 0.05 && spec.panel_height <= 3)) {
    throw Error("--screen-mm", "", fmt::format("{:g} {:g}", options.panel_mm[0], options.panel_mm[1]),
                "width and height of 50 to 3000");
  }
  spec.pixels = {options.pixels[0], options.pixels[1]};
  for (const auto layout : {display::Layout::kMono, display::Layout::kSideBySide, display::Layout::kTopBottom,
                            display::Layout::kRowInterleaved, display::Layout::kAnaglyph, display::Layout::kTwoOutputs,
                            display::Layout::kFrameSequential}) {
    if (name_of(layout) == options.layout) spec.layout = layout;
  }
  spec.eye_distance = options.eye_mm * kMillimetre, spec.ipd = options.ipd_mm * kMillimetre;
  spec.gaze = options.gaze_deg * kDegree, spec.mirror_tilt = options.mirror_deg * kDegree;
  spec.picture_tilt = options.picture_deg * kDegree;
  spec.glass_above_work = options.glass_mm * kMillimetre;
  spec.hand_room = options.hand_mm * kMillimetre, spec.comfort = options.comfort;
  if (options.arm_box_mm.empty()) {
    for (const ArmReach& arm : kArms) {
      if (arm.name == options.arm) spec.arm_box = arm.box_mm * kMillimetre;
    }
  } else {
    for (int i = 0; i < 3; ++i) spec.arm_box[i] = options.arm_box_mm[static_cast<std::size_t>(i)] * kMillimetre;
    if (!(std::min({spec.arm_box.x, spec.arm_box.y, spec.arm_box.z}) >= 0.01 &&
          std::max({spec.arm_box.x, spec.arm_box.y, spec.arm_box.z}) <= 3)) {
      throw Error("--arm-box-mm", "", fmt::format("{:g}", fmt::join(options.arm_box_mm, " ")),
                  "width, depth and height of 10 to 3000");
    }
  }
  return spec;
}

Value in_mm(const dvec3& p) {
  // Converts m to mm, rounded to 0.001 mm, because no bench is built more exactly.
  const auto rounded = [](double metres) { return std::round(metres * 1e6) / 1e3 + 0.0; };
  return {rounded(p.x), rounded(p.y), rounded(p.z)};
}

Value screen_value(const display::Screen& screen, const dvec3& shift) {
  return {{"lower_left", in_mm(screen.lower_left + shift)},
          {"lower_right", in_mm(screen.lower_right + shift)},
          {"upper_left", in_mm(screen.upper_left + shift)}};
}

Value plan_value(const BenchSpec& spec, const BenchPlan& plan) {
  Value json;
  json["fits"] = plan.conflicts.empty();
  json["conflicts"] = plan.conflicts;
  json["panel_mm"] = screen_value(plan.rig.screen, dvec3(0));
  json["picture_mm"] = screen_value(plan.picture, dvec3(0));
  const dvec3& normal = plan.rig.mirror->normal;
  json["mirror"] = {{"normal", {normal.x, normal.y, normal.z}}, {"offset_mm", plan.rig.mirror->offset * 1e3}};
  json["eye_center_mm"] = in_mm(plan.rig.head.eye_center);
  if (plan.glass_width > 0) {
    json["glass_mm"] = {{"width", plan.glass_width * 1e3}, {"length", plan.glass_length * 1e3}};
    json["glass_mm"]["corners"] = Value::array();
    for (const dvec3& corner : plan.glass) json["glass_mm"]["corners"].push_back(in_mm(corner));
  }
  json["arm_box_mm"] = in_mm(spec.arm_box);
  if (plan.low == plan.high) {
    json["workspace_mm"] = nullptr;
  } else {
    constexpr const char* kSides[] = {"left", "right", "near", "far", "lower", "upper"};
    json["workspace_mm"] = {
        {"low", in_mm(plan.low)}, {"high", in_mm(plan.high)}, {"size", in_mm(plan.high - plan.low)}};
    for (std::size_t f = 0; f < 6; ++f) json["workspace_mm"]["limits"][kSides[f]] = plan.faces[f].limit;
    json["comfortable_depth_mm"] = {plan.nearest * 1e3, plan.farthest * 1e3};  // infinite: null
  }
  json["pixel_mm"] = plan.pixel * 1e3;
  return json;
}

/// Makes the text of the rig file (JSON). `work`: position of the tissue in the scenes, m, frame W.
std::string rig_text(const BenchPlan& plan, const RigOptions& options, const dvec3& work) {
  const display::Mirror& mirror = *plan.rig.mirror;
  const Value rig = {
      {"display", "mirror"},
      {"screen",
       {{"corners_mm", screen_value(plan.rig.screen, work)}, {"pixels", options.pixels}, {"layout", options.layout}}},
      {"mirror",
       {{"normal", {mirror.normal.x, mirror.normal.y, mirror.normal.z}},
        {"offset_mm", (mirror.offset + glm::dot(mirror.normal, work)) * 1e3}}},
      {"head",
       {{"eye_center_mm", in_mm(plan.rig.head.eye_center + work)}, {"ipd_mm", options.ipd_mm}, {"right", {1, 0, 0}}}},
      {"X_WH", {{"translation_mm", in_mm(work)}, {"rotation_wxyz", {1, 0, 0, 0}}}}};
  return rig.dump(2) + "\n";
}

std::string plan_words(const BenchSpec& spec, const BenchPlan& plan) {
  const auto mm = [](const dvec3& p) {
    return fmt::format("({:.0f}, {:.0f}, {:.0f})", p.x * 1e3 + 0.0, p.y * 1e3 + 0.0, p.z * 1e3 + 0.0);
  };
  const auto& screen = plan.rig.screen;
  std::string text =
      "Lengths in mm. Origin: the middle of the work; x to the user's right, y away from the user, z up.\n";
  text += fmt::format("panel      lower left {}, lower right {}, upper left {}; tilted {:.0f}°\n",
                      mm(screen.lower_left), mm(screen.lower_right), mm(screen.upper_left),
                      (2 * spec.mirror_tilt - spec.picture_tilt) / kDegree + 0.0);
  if (plan.glass_width > 0) {
    text += fmt::format("mirror     at least {:.0f} × {:.0f}, near edge {} to {}, far edge {} to {}; tilted {:.0f}°\n",
                        plan.glass_width * 1e3, plan.glass_length * 1e3, mm(plan.glass[0]), mm(plan.glass[1]),
                        mm(plan.glass[3]), mm(plan.glass[2]), spec.mirror_tilt / kDegree + 0.0);
  }
  text += fmt::format("eyes       midway at {}, {:.0f} from the work\n", mm(plan.rig.head.eye_center),
                      spec.eye_distance * 1e3);
  text += fmt::format("arm        middle of its reach at (0, 0, 0), {:.0f} × {:.0f} × {:.0f}\n", spec.arm_box.x * 1e3,
                      spec.arm_box.y * 1e3, spec.arm_box.z * 1e3);
  if (plan.low != plan.high) {
    const dvec3 size = plan.high - plan.low;
    text += fmt::format("workspace  {:.0f} × {:.0f} × {:.0f}, from {} to {}\n", size.x * 1e3, size.y * 1e3,
                        size.z * 1e3, mm(plan.low), mm(plan.high));
    constexpr const char* kSides[] = {"left", "right", "near", "far", "lower", "upper"};
    for (std::size_t f = 0; f < 6; ++f) text += fmt::format("  {:<8} {}\n", kSides[f], plan.faces[f].limit);
  }
  text += fmt::format("pixel      {:.2f} wide in each eye's picture\n", plan.pixel * 1e3);
  return text;
}

void plan(const RigOptions& options) {
  const BenchSpec spec = spec_of(options);
  const BenchPlan result = display::plan_bench(spec);
  const dvec3 work = dvec3(options.work_mm[0], options.work_mm[1], options.work_mm[2]) * kMillimetre;
  if (!options.out.empty() && result.glass_width > 0) {
    constexpr std::array kKinds{FileKind::kDrawing, FileKind::kDocument};
    const FileKind kind = kind_of_name(options.out, kKinds);
    write_file_atomically(options.out, draw_bench(spec, result, kind), kind);
  }
  if (!options.rig.empty() && result.conflicts.empty()) {
    write_file_atomically(options.rig, rig_text(result, options, work), FileKind::kJson);
  }
  fmt::print("{}", options.json ? plan_value(spec, result).dump(2) + "\n" : plan_words(spec, result));
  if (!result.conflicts.empty())
    throw RunFailure(fmt::format("this bench does not fit: {}", fmt::join(result.conflicts, "; ")));
}

}  // namespace

void add_rig_command(cli::Command& app) {
  cli::Command* rig = app.add_command("rig", "Plan a bench: positions of panel, mirror, eyes and arm");
  rig->expect_commands(1, 1);
  rig->footer("Example: typodont rig plan --out bench.pdf");
  auto options = std::make_shared<RigOptions>();
  cli::Command* command =
      rig->add_command("plan", "plan a mirror bench: positions of its parts, and the size of the shared workspace");
  command->add_setting("--screen-mm", options->panel_mm, "width and height of the panel's lit area")->expected(2);
  command->add_setting("--pixels", options->pixels, "of the panel", cli::range(64, 16384))->expected(2);
  command->add_setting("--layout", options->layout, "how the two pictures share the panel",
                       cli::one_of({"mono", "side_by_side", "top_bottom", "row_interleaved", "anaglyph", "two_outputs",
                                    "frame_sequential"}));
  command->add_setting("--mirror-deg", options->mirror_deg,
                       "tilt of the glass from the horizontal; it rises away from the user", cli::range(-80.0, 80.0));
  command->add_setting("--glass-mm", options->glass_mm, "from the middle of the work to the glass, along its normal",
                       cli::range(20.0, 1000.0));
  command->add_setting("--picture-deg", options->picture_deg,
                       "tilt of the seen picture from the horizontal; 90 is upright", cli::range(-30.0, 120.0));
  command->add_setting("--eye-mm", options->eye_mm, "from the eyes to the middle of the work",
                       cli::range(150.0, 2000.0));
  command->add_setting("--gaze-deg", options->gaze_deg, "of the line of sight below the horizontal",
                       cli::range(0.0, 90.0));
  command->add_setting("--ipd-mm", options->ipd_mm, "between the eyes", cli::range(40.0, 80.0));
  std::vector<std::string> arms;
  for (const ArmReach& arm : kArms) arms.emplace_back(arm.name);
  command->add_setting("--arm", options->arm, "arm; its reach comes from the maker's data sheet", cli::one_of(arms));
  command
      ->add_option("--arm-box-mm", options->arm_box_mm,
                   "width, depth and height that the arm reaches, instead of --arm")
      ->expected(3);
  command->add_setting("--hand-mm", options->hand_mm, "room for the hand between the workspace and the glass",
                       cli::range(0.0, 300.0));
  command->add_setting("--comfort-dpt", options->comfort,
                       "greatest difference in dioptres between the picture and what is shown", cli::range(0.05, 2.0));
  command
      ->add_setting("--work-mm", options->work_mm,
                    "where the scenes have their work: the origin of the plan, for --rig")
      ->expected(3);
  command->add_option("--out", options->out, "write a drawing with measures: .svg or .pdf, one A4 page",
                      cli::writes({FileKind::kDrawing, FileKind::kDocument}));
  command->add_option("--rig", options->rig, "write a rig file as the start of a calibration, if the bench fits",
                      cli::writes({FileKind::kJson}));
  command->add_flag("--json", options->json, "print the plan as JSON");
  command->footer(
      "Exit status 1 if parts of the bench collide; the drawing shows where.\n"
      "Example: typodont rig plan --screen-mm 531 299 --mirror-deg 0 --arm touch --eye-mm 520 --out bench.pdf");
  command->callback([options] { plan(*options); });
}

}  // namespace typodont
