#include "calibration/rig_file.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cmath>
#include <ctime>

#include "calibration/calibration_files.h"
#include "calibration/joint_solver.h"
#include "calibration/report/json_values.h"
#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/base/units.h"

namespace typodont::calibration {

struct RigFile::Document {
  std::filesystem::path file;
  Value root;
};

namespace {

constexpr double kMinIpd_mm = 20, kMaxIpd_mm = 100;

Value mm(double metres) {
  return number_value(metres * 1e3);
}

Value screen_corners(const Panel& panel) {
  return {{"lower_left", mm_value(panel.lower_left)},
          {"lower_right", mm_value(panel.lower_right)},
          {"upper_left", mm_value(panel.upper_left)}};
}

Value arm_value(const ArmGeometry& arm) {
  Value value;
  const auto v = to_vector(arm);
  const auto names = arm_parameter_names();
  for (std::size_t i = 0; i < v.size(); ++i)
    value[arm_parameter_key(names[i])] = v[i] / arm_parameter_unit(names[i]).si;
  return value;
}

Pose read_pose(const Json& json) {
  json.allow_only({"translation_mm", "rotation_wxyz"});
  const auto q = json["rotation_wxyz"].numbers(4);
  const dquat R(q[0], q[1], q[2], q[3]);
  if (std::abs(glm::length(R) - 1) > 1e-3) json["rotation_wxyz"].fail("a unit quaternion");
  return {json["translation_mm"].vec3() * kMillimetre, glm::normalize(R)};
}

Value steps_value(const BenchState& bench) {
  Value steps = Value::object();
  if (const auto& r = bench.arm_result) {
    Value step = {{"before_rms_mm", mm(r->before_rms)},
                  {"after_rms_mm", mm(r->after_rms)},
                  {"sigma_mm", mm(r->sigma)},
                  {"captures", r->residuals.size()},
                  {"rejected", r->rejected},
                  {"not_observable", r->not_observable}};
    if (!r->misfit.empty()) step["misfit"] = r->misfit;
    for (const ArmParameter& p : r->parameters) {
      const ArmUnit unit = arm_parameter_unit(p.name);
      step["parameters"].push_back({{"name", p.name},
                                    {"unit", unit.si == 1 ? "1" : unit.name},
                                    {"before", p.before / unit.si},
                                    {"after", p.after / unit.si},
                                    {"sigma", p.sigma / unit.si},
                                    {"determined", p.determined}});
    }
    steps["arm"] = step;
  }
  if (const auto& r = bench.panel_result) {
    steps["screen"] = {{"width_mm", mm(r->width)},
                       {"width_sigma_mm", mm(r->width_sigma)},
                       {"height_mm", mm(r->height)},
                       {"height_sigma_mm", mm(r->height_sigma)},
                       {"centre_sigma_mm", mm_value(r->centre_sigma)},
                       {"tilt_sigma_deg", r->tilt_sigma / kDegree},
                       {"rms_mm", mm(r->rms)},
                       {"sigma_mm", mm(r->sigma)},
                       {"rejected", r->rejected},
                       {"not_determined", r->not_determined}};
  }
  if (const auto& r = bench.mirror_result) {
    steps["mirror"] = {{"tilt_sigma_deg", r->tilt_sigma / kDegree},
                       {"offset_sigma_mm", mm(r->offset_sigma)},
                       {"rms_mm", mm(r->rms)},
                       {"sigma_mm", mm(r->sigma)},
                       {"rejected", r->rejected},
                       {"not_determined", r->not_determined}};
  }
  if (const auto& r = bench.eyes_result) {
    steps["eyes"] = {{"center_sigma_mm", mm_value(r->center_sigma)},
                     {"ipd_mm", mm(r->eyes.ipd)},
                     {"ipd_sigma_mm", mm(r->ipd_sigma)},
                     {"rms_mm", mm(r->rms)},
                     {"sigma_mm", mm(r->sigma)},
                     {"rejected", r->rejected},
                     {"not_determined", r->not_determined}};
    if (const auto& offset = r->user_offset) {
      steps["eyes"]["user_offset_mm"] = mm_value(offset->W);
      steps["eyes"]["user_offset_sigma_mm"] = mm_value(offset->sigma);
    }
  }
  if (const auto& r = bench.joint) {
    Value kinds = Value::array();
    for (const auto& kind : r->kinds) {
      kinds.push_back({{"name", kind.name},
                       {"touches", kind.touches},
                       {"rejected", kind.rejected},
                       {"before_rms_mm", mm(kind.before_rms)},
                       {"after_rms_mm", mm(kind.after_rms)}});
    }
    Value terms = Value::array();
    for (const auto& term : r->terms) {
      const bool curvature = term.name == kMirrorCurved;
      const double unit = curvature ? 1 : kMillimetre;
      terms.push_back({{"name", term.name},
                       {curvature ? "curvature_per_m" : "size_mm", vec3_value(term.value / unit)},
                       {"sigma", vec3_value(term.sigma / unit)},
                       {"evidence", term.evidence}});
    }
    steps["joint"] = {{"user_offset_mm", mm_value(r->user_offset_W)},
                      {"user_offset_sigma_mm", mm_value(r->user_offset_sigma)},
                      {"eye_center_sigma_mm", mm_value(r->eye_center_sigma)},
                      {"ipd_sigma_mm", mm(r->ipd_sigma)},
                      {"kinds", kinds},
                      {"terms", terms}};
  }
  if (const auto& r = bench.registration) {
    Value step = Value::parse(registration_json(*r, {}));
    step.erase("residuals_mm");
    steps["register"] = step;
  }
  if (const auto& r = bench.delay) steps["delay"] = Value::parse(delay_json(*r));
  if (const auto& r = bench.verification) {
    steps["verify"] = {{"pass", r->pass},
                       {"verdict", r->verdict},
                       {"points", r->points},
                       {"rms_mm", mm(r->rms)},
                       {"worst_mm", mm(r->worst)},
                       {"uncertainty_mm", mm(r->uncertainty)},
                       {"raw_rms_mm", mm(r->raw_rms)},
                       {"raw_mean_mm", mm(r->raw_mean)},
                       {"raw_worst_mm", mm(r->raw_worst)},
                       {"noise_mm", mm(r->noise)},
                       {"outliers", r->outliers},
                       {"tolerance_mm", {{"rms", mm(r->tolerance.rms)}, {"worst", mm(r->tolerance.worst)}}}};
  }
  return steps;
}

}  // namespace

std::string bench_json(const BenchState& bench) {
  return steps_value(bench).dump(2) + "\n";
}

RigFile::RigFile(std::unique_ptr<Document> document) : document_(std::move(document)) {}
RigFile::RigFile(RigFile&&) noexcept = default;
RigFile::~RigFile() = default;

RigFile RigFile::load(const std::filesystem::path& file) {
  // Json::load checks the file, because its errors state the position in the file.
  const Json checked = Json::load(file);
  if (!checked.is_object()) checked.fail("a rig: an object");
  auto document = std::make_unique<Document>();
  document->file = file;
  document->root = Value::parse(checked.text());
  RigFile rig(std::move(document));
  rig.bench();  // checks the file now, not after an hour of touches
  return rig;
}

RigFile RigFile::create(const std::filesystem::path& file) {
  auto document = std::make_unique<Document>();
  document->file = file;
  document->root = {{"display", "mirror"}, {"screen", {{"pixels", {1920, 1080}}, {"layout", "side_by_side"}}}};
  return RigFile(std::move(document));
}

BenchState RigFile::bench() const {
  const Json json = Json::parse(document_->root.dump(), document_->file.string());
  BenchState bench;
  if (const auto screen = json.find("screen"); screen && screen->has("corners_mm")) {
    const Json corners = (*screen)["corners_mm"];
    corners.allow_only({"lower_left", "lower_right", "upper_left"});
    const auto bow = screen->find("bow_mm");
    bench.rig.panel = {corners["lower_left"].vec3() * kMillimetre, corners["lower_right"].vec3() * kMillimetre,
                       corners["upper_left"].vec3() * kMillimetre, bow ? bow->vec3() * kMillimetre : dvec3(0)};
    const Panel& p = bench.rig.panel;
    if (glm::length(glm::cross(p.lower_right - p.lower_left, p.upper_left - p.lower_left)) < 1e-6) {
      corners.fail("three corners that span a rectangle");
    }
  }
  if (const auto mirror = json.find("mirror")) {
    const dvec3 normal = (*mirror)["normal"].vec3();
    if (glm::length(normal) < 1e-6) (*mirror)["normal"].fail("a direction");
    bench.rig.mirror = MirrorPlane{glm::normalize(normal), mirror->number_or("offset_mm", 0) * kMillimetre};
    if (const auto curvature = mirror->find("curvature_per_m")) {
      bench.rig.mirror->curvature = curvature->vec3();
      bench.rig.mirror->middle = (*mirror)["middle_mm"].vec3() * kMillimetre;
    }
  }
  if (const auto head = json.find("head")) {
    bench.rig.eyes.center = (*head)["eye_center_mm"].vec3() * kMillimetre;
    bench.rig.eyes.ipd = head->number_or("ipd_mm", 63, kMinIpd_mm, kMaxIpd_mm) * kMillimetre;
    if (const auto right = head->find("right")) {
      if (glm::length(right->vec3()) < 1e-6) right->fail("a direction");
      bench.rig.eyes.right = glm::normalize(right->vec3());
    }
  }
  if (const auto X_WH = json.find("X_WH")) bench.rig.X_WH = read_pose(*X_WH);
  if (const auto block = json.find("calibration")) {
    if (const auto arm = block->find("arm")) bench.arm = read_arm_geometry(*arm);
    if (const auto box = block->find("workspace_mm")) {
      const auto v = box->numbers(6);
      bench.workspace_D = {dvec3(v[0], v[1], v[2]) * kMillimetre, dvec3(v[3], v[4], v[5]) * kMillimetre};
      if (!(v[0] < v[3] && v[1] < v[4] && v[2] < v[5])) box->fail("x0,y0,z0 below x1,y1,z1");
    }
  }
  return bench;
}

std::filesystem::path RigFile::captures_folder() const {
  const auto block = document_->root.find("calibration");
  if (block != document_->root.end() && block->contains("captures") && (*block)["captures"].is_string()) {
    return document_->file.parent_path() / (*block)["captures"].get<std::string>();
  }
  return document_->file.string() + ".captures";
}

/// Throws Error if the program could not open this rig later.
static void require_usable(const std::filesystem::path& file, const BenchState& bench, const Value& pixels) {
  const RigGeometry& rig = bench.rig;
  constexpr double kMinEdge = 10e-3, kMaxEdge = 3;  // m, smallest and largest edge of the panel
  const double ipd_mm = rig.eyes.ipd / kMillimetre;
  if (!(ipd_mm >= kMinIpd_mm && ipd_mm <= kMaxIpd_mm))
    throw Error(file.string(), "head.ipd_mm", fmt::format("{:.1f}", ipd_mm),
                "20 to 100; were the captures of the left and the right eye exchanged? The file is as before");
  const double width = glm::distance(rig.panel.lower_left, rig.panel.lower_right),
               height = glm::distance(rig.panel.lower_left, rig.panel.upper_left);
  for (const double edge : {width, height}) {
    if (!(edge >= kMinEdge && edge <= kMaxEdge))
      throw Error(file.string(), "screen.corners_mm",
                  fmt::format("a panel of {:.2f} x {:.2f} mm", width / kMillimetre, height / kMillimetre),
                  "edges of 10 to 3000 mm; are the touches in metres instead of mm? The file is as before");
  }
  if (!bench.panel_result || !pixels.is_array()) return;
  const PanelResult& touched = *bench.panel_result;
  const double ratio = (width / pixels.at(0).get<double>()) / (height / pixels.at(1).get<double>());
  const double sigma = std::hypot(touched.width_sigma / width, touched.height_sigma / height);
  // Largest deviation of a pixel's aspect ratio from 1; panels on sale: below 0.002.
  constexpr double kNotSquare = 0.01;
  if (std::abs(ratio - 1) > kNotSquare + 3 * sigma)
    throw Error(file.string(), "screen.corners_mm",
                fmt::format("a panel of {:.1f} x {:.1f} mm, whose pixels are {:.1f} % wider than high",
                            width / kMillimetre, height / kMillimetre, 100 * (ratio - 1)),
                fmt::format("square pixels; does the arm read {:.1f} % too much along one axis, or are the \"pixels\" "
                            "({} x {}) not those of the panel? The file is as before",
                            100 * std::abs(ratio - 1), pixels.at(0).get<int>(), pixels.at(1).get<int>()));
}

void RigFile::set(const BenchState& bench) {
  Value& root = document_->root;
  require_usable(document_->file, bench, root.value(nlohmann::json_pointer<std::string>("/screen/pixels"), Value()));
  root["screen"]["corners_mm"] = screen_corners(bench.rig.panel);
  root["screen"].erase("bow_mm");
  if (bench.rig.panel.bow != dvec3(0)) root["screen"]["bow_mm"] = mm_value(bench.rig.panel.bow);
  if (bench.rig.mirror) {
    root["mirror"]["normal"] = vec3_value(bench.rig.mirror->normal);
    root["mirror"]["offset_mm"] = mm(bench.rig.mirror->offset);
    root["mirror"].erase("middle_mm"), root["mirror"].erase("curvature_per_m");
    if (bench.rig.mirror->curvature != dvec3(0)) {
      root["mirror"]["middle_mm"] = mm_value(bench.rig.mirror->middle);
      root["mirror"]["curvature_per_m"] = vec3_value(bench.rig.mirror->curvature);
    }
  }
  root["head"]["eye_center_mm"] = mm_value(bench.rig.eyes.center);
  root["head"]["ipd_mm"] = mm(bench.rig.eyes.ipd);
  root["head"]["right"] = vec3_value(bench.rig.eyes.right);
  root["X_WH"] = pose_value(bench.rig.X_WH);
  Value& block = root["calibration"];
  block["captures"] = captures_folder().filename().string();
  const Box& box = bench.workspace_D;
  block["workspace_mm"] = {box.low.x * 1e3,  box.low.y * 1e3,  box.low.z * 1e3,
                           box.high.x * 1e3, box.high.y * 1e3, box.high.z * 1e3};
  block["arm"] = arm_value(bench.arm);
  const Value steps = steps_value(bench);
  const std::string now = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  for (const auto& [name, step] : steps.items()) {
    block["steps"][name] = step;
    block["steps"][name]["date"] = now;
  }
}

std::string RigFile::step_date(const std::string& step) const {
  const auto date =
      document_->root.value(nlohmann::json_pointer<std::string>("/calibration/steps/" + step + "/date"), Value());
  return date.is_string() ? date.get<std::string>() : std::string();
}

void RigFile::mark_done(const std::string& step) {
  document_->root["calibration"]["steps"][step]["date"] =
      fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
}

void RigFile::set_device(const std::string& role, const std::string& serial) {
  document_->root["calibration"]["devices"][role] = serial;
}

void RigFile::save() {
  document_->root["calibration"]["date"] = fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr)));
  write_file_atomically(document_->file, document_->root.dump(2) + "\n", FileKind::kJson, Over::kItsInput);
}

}  // namespace typodont::calibration
