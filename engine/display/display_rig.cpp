#include "engine/display/display_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/base/error.h"
#include "engine/base/keys.h"
#include "engine/base/line_of_sight.h"
#include "engine/base/units.h"
#include "engine/display/head_tracker.h"

namespace typodont::display {

namespace {

constexpr std::array<std::string_view, 4> kKinds{"window", "mirror", "hmd", "offscreen"};
constexpr std::array<std::string_view, 7> kLayouts{"mono",     "side_by_side", "top_bottom",      "row_interleaved",
                                                   "anaglyph", "two_outputs",  "frame_sequential"};

dvec3 unit_vector(const Json& json) {
  const dvec3 v = json.vec3();
  const double length = glm::length(v);
  if (length < 1e-9) json.fail("a direction that is not zero");
  return v / length;
}

void describe_corners(Keys& keys, Screen& screen) {
  keys(must("lower_left"), screen.lower_left, kMillimetre, "lower left corner");
  keys(must("lower_right"), screen.lower_right, kMillimetre, "lower right corner");
  keys(must("upper_left"), screen.upper_left, kMillimetre, "upper left corner");
  const Json* corners = keys.json();
  if (!corners) return;
  const dvec3 right = screen.lower_right - screen.lower_left, up = screen.upper_left - screen.lower_left;
  const double width = glm::length(right), height = glm::length(up);
  if (width < 1e-3) (*corners)["lower_right"].fail("at least 1 mm away from lower_left");
  if (height < 1e-3) (*corners)["upper_left"].fail("at least 1 mm away from lower_left");
  const double off_square = std::abs(std::asin(std::clamp(glm::dot(right, up) / (width * height), -1.0, 1.0)));
  if (off_square > 2 * kDegree)
    corners->fail(fmt::format("edges {:.1f} degrees off a right angle", off_square / kDegree),
                  "the corners of a rectangle, within 2 degrees");
}

void describe_screen(Keys& keys, Screen& screen) {
  keys(must("corners_mm"), screen, describe_corners, "corners of the panel, named as in the upright picture");
  if (const auto pixels = keys("pixels", kPair, "width and height, 16–16384; default [1920, 1080]")) {
    const std::vector<Json> items = pixels->items();
    if (items.size() != 2) pixels->fail("[width, height]");
    screen.pixels = {static_cast<int>(items[0].integer(16, 16384)), static_cast<int>(items[1].integer(16, 16384))};
  }
  keys("layout", screen.layout, kLayouts, "`frame_sequential` needs a Vulkan surface with two layers");
  keys("bow_mm", screen.bow, kMillimetre,
       "a bent panel: height of the middle of the lower edge, of the left edge, and of the upper right corner, above "
       "the plane of the three corners");
  const double edge = std::min(glm::distance(screen.lower_left, screen.lower_right),
                               glm::distance(screen.lower_left, screen.upper_left));
  for (int i = 0; i < 3; ++i)
    if (std::abs(screen.bow[i]) > 0.05 * edge)
      (*keys.json())["bow_mm"].fail("a twentieth of the panel's height or less");
}

void describe_mirror(Keys& keys, Mirror& mirror) {
  // The plane n·p = c is the same as (n/|n|)·p = c/|n|, so both n and c are divided by |n|.
  double length = 1;
  if (const auto normal = keys(must("normal"), kDirection, "normal n of the plane n·p = `offset_mm`")) {
    length = glm::length(normal->vec3());
    mirror.normal = unit_vector(*normal);
  }
  keys(must("offset_mm"), mirror.offset, {.unit = kMillimetre}, "offset of the plane");
  mirror.offset /= length;
  keys("middle_mm", kPoint, "with `curvature_per_m`: the mirror is curved about its point nearest to this one");
  if (const auto curvature =
          keys("curvature_per_m", kPoint, "curvature of the mirror ([axes](../engine/base/line_of_sight.h))")) {
    mirror.curvature = curvature->vec3();
    for (int i = 0; i < 3; ++i)
      if (std::abs(mirror.curvature[i]) > 0.5) curvature->fail("a radius of at least 2 m");
    mirror.middle = (*keys.json())["middle_mm"].vec3() * kMillimetre;
  }
  keys("glass_thickness_mm", mirror.glass_thickness, {0, 50, kMillimetre}, "thickness of the glass");
  keys("glass_index", mirror.glass_index, {1, 3}, "refractive index of the glass");
}

void describe_head(Keys& keys, Head& head) {
  keys(must("eye_center_mm"), head.eye_center, kMillimetre, "midpoint between the eyes");
  keys("ipd_mm", head.ipd, {0, 100, kMillimetre}, "interpupillary distance");
  keys("right", head.right, unit_vector, "from the left to the right eye; default [1, 0, 0]");
  keys("tracker", head.tracker, "[head tracker](#head-tracker)");
  if (!head.tracker.empty() && !parse_tracker_address(head.tracker))
    (*keys.json())["tracker"].fail("\"opentrack:PORT\" or \"opentrack:ADDRESS:PORT\" with a port from 1 to 65535");
}

void describe_pose(Keys& keys, Pose& pose) {
  keys(must("translation_mm"), pose.p, kMillimetre, "position");
  if (const auto rotation = keys(must("rotation_wxyz"), kQuaternion, "rotation as a unit quaternion")) {
    const std::vector<double> q = rotation->numbers(4);
    pose.R = dquat(q[0], q[1], q[2], q[3]);
    const double length = glm::length(pose.R);
    if (std::abs(length - 1) > 1e-3) rotation->fail(fmt::format("a quaternion of length {:.6g}", length), "length 1");
    pose.R = pose.R / length;
  }
}

void describe_hmd(Keys& keys, HmdRig& hmd, const Pose& X_WH) {
  enum class Space { kStage, kLocal } space = Space::kStage;
  keys("space", space, {"stage", "local"}, "OpenXR reference space");
  hmd.stage = space == Space::kStage;
  keys("X_WD", hmd.X_WD, describe_pose,
       "measured pose of the reference space in W, instead of `distance_mm`, `below_mm` and `magnify`");
  if (const auto file =
          keys("registration", kFile, "a file of `calibrate register` instead of `X_WD`: X_WD = X_WH · X_DH⁻¹")) {
    if (hmd.X_WD) file->fail("either X_WD or registration");
    // X_DH: pose of the haptic base in the headset's space D.
    const Json found = Json::load(file->file().parent_path() / file->string());
    hmd.X_WD = X_WH * inverse(read_keys(found["X_DH"], describe_pose));
  }
  keys("magnify", hmd.magnify, {0.1, 100}, "magnification, also of a controller's motion");
  if (hmd.X_WD && hmd.magnify != 1)
    (*keys.json())["magnify"].fail("1, where the space is measured: the arm is life-size");
  keys("distance_mm", hmd.distance, {100, 5000, kMillimetre}, "distance of the work in front of the eyes");
  keys("below_mm", hmd.below, {-2000, 2000, kMillimetre}, "distance of the work below the eyes");
  keys("passthrough", hmd.passthrough, "true: shows the real room (blend modes, XR_FB_passthrough)");
  keys("depth", hmd.depth, "false: no depth layer");
  keys("refresh_hz", hmd.refresh_hz, {0, 1000}, "display rate; 0: the runtime's choice");
  keys("resolution", hmd.resolution, {0.1, 2}, "factor on the recommended resolution");
  keys("wait_s", hmd.wait, {0.1, 3600}, "longest wait until the headset is put on");
  keys("stall_s", hmd.stall, {0.1, 60}, "the session ends if the runtime does not answer for this time");
  keys("tip_mm", hmd.tip, kMillimetre, "centre of the tool's head in the controller's aim frame");
}

}  // namespace

std::string_view name_of(DisplayKind kind) noexcept {
  return kKinds[static_cast<std::size_t>(kind)];
}
std::string_view name_of(Layout layout) noexcept {
  return kLayouts[static_cast<std::size_t>(layout)];
}

DisplayRig load_rig(const std::filesystem::path& file) {
  return parse_rig(Json::load(file));
}

DisplayRig parse_rig(const Json& json) {
  return read_keys(json, describe_rig);
}

void describe_rig(Keys& keys, DisplayRig& rig) {
  const Json* json = keys.json();
  keys(must("display"), rig.kind, kKinds, "kind of display; `hmd`: a headset");
  keys("screen", rig.screen, describe_screen, "the panel; required for `mirror`");
  if (json && rig.kind == DisplayKind::kMirror) (void)(*json)["screen"];
  keys("mirror", rig.mirror, describe_mirror, "the mirror in which the user sees the panel");
  keys("head", rig.head, describe_head, "the user's eyes");
  keys("X_WH", rig.X_WH, describe_pose, "pose in W of the base of the hand's device");
  keys("left_X_WH", rig.left_X_WH, describe_pose, "pose in W of the base of the second hand's device");
  keys("hand", rig.hand,
       "device by [address](#devices-and-outputs-by-address), such as `woodenhaptics:1234567` (serial number); options "
       "of the same names override the three devices");
  keys("left_hand", rig.left_hand, "device of the second hand");
  keys("pedal", rig.pedal, "foot pedal");
  keys("pedal_limit_s", rig.pedal_limit, {1, 3600},
       "a pedal pressed for longer counts as stuck: the drill stops. Default: 120");
  const auto calibration =
      keys("calibration", kAnyObject,
           "results of [`calibrate`](../calibration/README.md); `steps.arm.misfit`: why an arm's poses were rejected");
  if (calibration && calibration->is_object()) {
    const auto steps = calibration->find("steps");
    const auto step = steps && steps->is_object() ? steps->find("arm") : std::nullopt;
    const auto arm = calibration->find("arm");
    if (arm && step && step->is_object() && !step->has("misfit")) rig.arm = read_arm_geometry(*arm);
  }
  keys(
      "hmd", [&](Keys& of) { describe_hmd(of, rig.hmd, rig.X_WH); }, "[headset](#the-rig-of-a-headset)");
  keys("magnify", rig.magnify, {0.1, 100}, "[magnification](#magnification)");
  if (json && rig.kind == DisplayKind::kHmd && json->has("magnify"))
    (*json)["magnify"].fail("in \"hmd\": a headset's work is put before the user with it");
  if (const auto about =
          keys("magnify_about_mm", kPoint, "centre of the magnification; default: middle of the tissue's upper side")) {
    rig.magnify_about = about->vec3() * kMillimetre;
    if (rig.magnify == 1) about->fail("\"magnify\" beside it");
  }
  if (!json || rig.kind == DisplayKind::kHmd) return;
  try {
    (void)eye_views(rig);
  } catch (const Error& e) {
    (json->has("head") ? (*json)["head"]["eye_center_mm"] : *json).fail(e.what(), "eyes in front of the picture");
  }
}

DisplayRig magnified(const DisplayRig& rig, const dvec3& about) {
  if (rig.magnify == 1) return rig;
  DisplayRig shrunk = rig;
  const double s = 1 / rig.magnify;
  const dvec3 c = rig.magnify_about.value_or(about);
  for (dvec3* p :
       {&shrunk.screen.lower_left, &shrunk.screen.lower_right, &shrunk.screen.upper_left, &shrunk.head.eye_center})
    *p = c + s * (*p - c);
  shrunk.head.ipd *= s;
  shrunk.screen.bow *= s;
  if (shrunk.mirror) {
    const double middle = glm::dot(shrunk.mirror->normal, c);
    shrunk.mirror->offset = middle + s * (shrunk.mirror->offset - middle);
    shrunk.mirror->middle = c + s * (shrunk.mirror->middle - c);
    shrunk.mirror->curvature /= s;
    shrunk.mirror->glass_thickness *= s;
  }
  shrunk.scale *= s;
  shrunk.magnify = 1;
  return shrunk;
}

dmat4 opengl_projection(const Frustum& f) {
  // Arguments as in glFrustum(l, r, b, t, n, f), Kooima 2009, section 5. GLM's index order: m[column][row].
  dmat4 m(0.0);
  m[0][0] = 2 * f.near / (f.right - f.left);
  m[1][1] = 2 * f.near / (f.top - f.bottom);
  m[2][0] = (f.right + f.left) / (f.right - f.left);
  m[2][1] = (f.top + f.bottom) / (f.top - f.bottom);
  m[2][2] = -(f.far + f.near) / (f.far - f.near);
  m[2][3] = -1;
  m[3][2] = -2 * f.far * f.near / (f.far - f.near);
  return m;
}

dmat4 vulkan_projection(const Frustum& f) {
  // OpenGL's projection with y negated and depth 0..1.
  dmat4 m = opengl_projection(f);
  m[1][1] = -m[1][1];
  m[2][1] = -m[2][1];
  m[2][2] = -f.far / (f.far - f.near);
  m[3][2] = -f.far * f.near / (f.far - f.near);
  return m;
}

dvec3 reflect(const Mirror& mirror, const dvec3& p) {
  return p - 2 * (glm::dot(mirror.normal, p) - mirror.offset) * mirror.normal;
}

dmat4 reflection(const Mirror& mirror) {
  // Reflection in the plane n·x = c: [[I − 2nnᵀ, 2cn], [0, 1]].
  const dvec3 n = mirror.normal;
  const glm::dmat3 linear = glm::dmat3(1.0) - 2.0 * glm::outerProduct(n, n);
  dmat4 h(linear);
  h[3] = glm::dvec4(2 * mirror.offset * n, 1);
  return h;
}

Screen reflect(const Mirror& mirror, const Screen& screen) {
  Screen virtual_screen = screen;
  virtual_screen.lower_left = reflect(mirror, screen.lower_left);
  virtual_screen.lower_right = reflect(mirror, screen.lower_right);
  virtual_screen.upper_left = reflect(mirror, screen.upper_left);
  return virtual_screen;
}

dvec3 glass_shift(const Screen& panel, const Mirror& mirror, const dvec3& p_WC) {
  if (mirror.glass_thickness <= 0) return dvec3(0);
  // Glass shifts the picture towards the eye by t (1 − cos θ / √(n² − sin² θ)). t: thickness; n: index; θ: to normal.
  const Screen screen = reflect(mirror, panel);
  const dvec3 middle = 0.5 * (screen.lower_right + screen.upper_left);
  const dvec3 to_eye = glm::dot(mirror.normal, p_WC) > mirror.offset ? mirror.normal : -mirror.normal;
  const double cosine = std::abs(glm::dot(glm::normalize(middle - p_WC), mirror.normal));
  const double sine2 = 1 - cosine * cosine, index2 = mirror.glass_index * mirror.glass_index;
  return mirror.glass_thickness * (1 - cosine / std::sqrt(index2 - sine2)) * to_eye;
}

EyeView eye_view(const Screen& panel, const std::optional<Mirror>& mirror, const dvec3& p_WE, const ClipRange& range,
                 const dvec3& shift) {
  const Screen screen = mirror ? reflect(*mirror, panel) : panel;
  const dvec3 right_edge = screen.lower_right - screen.lower_left, up_edge = screen.upper_left - screen.lower_left;
  const dvec3 v_r = glm::normalize(right_edge), v_u = glm::normalize(up_edge);
  // Axes: right, up and towards the eye. A mirror image emits light in the direction −(v_r × v_u). So with a mirror,
  // v_n is reversed, and the frame is left-handed (determinant −1).
  const dvec3 v_n = glm::normalize(glm::cross(v_r, v_u)) * (mirror ? -1.0 : 1.0);

  const dvec3 v_a = screen.lower_left - p_WE, v_b = screen.lower_right - p_WE, v_c = screen.upper_left - p_WE;
  const double d = -glm::dot(v_n, v_a);
  if (!(d > 1e-6))
    throw Error(fmt::format("an eye {:.1f} mm behind the picture, at [{:.1f}, {:.1f}, {:.1f}] mm", -d / kMillimetre,
                            p_WE.x / kMillimetre, p_WE.y / kMillimetre, p_WE.z / kMillimetre));

  EyeView eye;
  eye.position = p_WE;
  eye.flip = mirror.has_value();
  eye.frustum = {glm::dot(v_r, v_a) * range.near / d,
                 glm::dot(v_r, v_b) * range.near / d,
                 glm::dot(v_u, v_a) * range.near / d,
                 glm::dot(v_u, v_c) * range.near / d,
                 range.near,
                 range.far};

  const glm::dmat3 rows = glm::transpose(glm::dmat3(v_r, v_u, v_n));
  eye.view = dmat4(rows);
  eye.view[3] = glm::dvec4(rows * (shift - p_WE), 1);
  eye.projection = vulkan_projection(eye.frustum);
  return eye;
}

std::array<dvec3, 2> eye_positions(const Head& head, Layout layout) {
  if (layout == Layout::kMono) return {head.eye_center, head.eye_center};
  return {head.eye_center - 0.5 * head.ipd * head.right, head.eye_center + 0.5 * head.ipd * head.right};
}

bool sees(const DisplayRig& rig, const Head& head) noexcept {
  constexpr double kNearest = 0.05;  // m, smallest allowed distance of the eyes from the screen
  const dvec3 n = glm::normalize(
      glm::cross(rig.screen.lower_right - rig.screen.lower_left, rig.screen.upper_left - rig.screen.lower_left));
  for (const dvec3& eye : eye_positions(head, rig.screen.layout)) {
    const dvec3 real = rig.mirror ? reflect(*rig.mirror, eye) : eye;
    if (!(glm::dot(n, real - rig.screen.lower_left) >= kNearest * rig.scale)) return false;
  }
  return true;
}

ClipRange clip_range(const DisplayRig& rig) {
  const dvec3 n = glm::normalize(
      glm::cross(rig.screen.lower_right - rig.screen.lower_left, rig.screen.upper_left - rig.screen.lower_left));
  const dvec3 eye = rig.mirror ? reflect(*rig.mirror, rig.head.eye_center) : rig.head.eye_center;
  const double d = glm::dot(n, eye - rig.screen.lower_left);
  ClipRange range;
  if (d < 0.2) range.near = std::max(d, 2e-3 * rig.scale) / 2;
  if (d > 1.0) range.far = 2 * d;
  return range;
}

std::array<EyeView, 2> eye_views(const DisplayRig& rig) {
  const auto eyes = eye_positions(rig.head, rig.screen.layout);
  const ClipRange range = clip_range(rig);
  const dvec3 shift = rig.mirror ? glass_shift(rig.screen, *rig.mirror, rig.head.eye_center) : dvec3(0);
  return {eye_view(rig.screen, rig.mirror, eyes[0], range, shift),
          eye_view(rig.screen, rig.mirror, eyes[1], range, shift)};
}

std::optional<Warp> warp(const DisplayRig& rig) {
  const Screen& s = rig.screen;
  const bool curved = rig.mirror && rig.mirror->curvature != dvec3(0);
  if (s.bow == dvec3(0) && !curved) return std::nullopt;
  using sight::vec;
  const sight::Panel<double> panel{vec<double>(s.lower_left), vec<double>(s.lower_right - s.lower_left),
                                   vec<double>(s.upper_left - s.lower_left), vec<double>(s.bow)};
  sight::Panel<double> plane = panel;
  plane.bow = {};
  std::optional<sight::Mirror<double>> mirror, plane_mirror;
  if (rig.mirror) {
    const Mirror& m = *rig.mirror;
    mirror =
        sight::Mirror<double>::make(vec<double>(m.normal), m.offset, vec<double>(m.middle), vec<double>(m.curvature));
    plane_mirror = mirror;
    plane_mirror->curvature = {};
  }
  Warp result;
  const auto eyes = eye_positions(rig.head, s.layout);
  for (std::size_t e = 0; e < 2; ++e) {
    for (int row = 0; row < kWarpSide; ++row) {
      for (int column = 0; column < kWarpSide; ++column) {
        const sight::Vec<double> p = panel.at(column / (kWarpSide - 1.0), 1 - row / (kWarpSide - 1.0));
        const dvec3 seen = sight::plain(mirror ? sight::seen_in(*mirror, vec<double>(eyes[e]), p) : p);
        const auto [u, v] = sight::pixel_through(plane, plane_mirror ? &*plane_mirror : nullptr, eyes[e], seen);
        result[e].push_back({static_cast<float>(u), static_cast<float>(1 - v)});
      }
    }
  }
  return result;
}

dmat2 upright(const DisplayRig& rig) {
  const Screen screen = rig.mirror ? reflect(*rig.mirror, rig.screen) : rig.screen;
  const dvec3 v_r = glm::normalize(screen.lower_right - screen.lower_left);
  const dvec3 v_u = glm::normalize(screen.upper_left - screen.lower_left);
  const dvec3 towards_eye = glm::normalize(glm::cross(v_r, v_u)) * (rig.mirror ? -1.0 : 1.0);
  const dvec3 user_right = rig.head.right, user_up = glm::cross(towards_eye, user_right);
  const auto nearest_axis = [&](const dvec3& v) -> dvec2 {
    const double x = glm::dot(v, v_r), y = glm::dot(v, v_u);
    return std::abs(x) >= std::abs(y) ? dvec2(x < 0 ? -1 : 1, 0) : dvec2(0, y < 0 ? -1 : 1);
  };
  const dvec2 right = nearest_axis(user_right);
  dvec2 up = nearest_axis(user_up);
  if (glm::dot(right, up) != 0) up = dvec2(-right.y, right.x) * (rig.mirror ? -1.0 : 1.0);
  return dmat2(right, up);
}

std::array<double, 16> row_major_mm(const dmat4& view) {
  std::array<double, 16> m{};
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 4; ++column) {
      const double unit = column == 3 && row < 3 ? 1 / kMillimetre : 1.0;
      m[static_cast<std::size_t>(4 * row + column)] = view[column][row] * unit;
    }
  return m;
}

std::array<double, 16> row_major_mm_projection(const Frustum& frustum) {
  // P23 is the only length in the projection; row_major_mm() converts it to mm.
  return row_major_mm(vulkan_projection(frustum));
}

ivec2 eye_pixels(Layout layout, const ivec2& p) {
  if (layout == Layout::kSideBySide) return {std::max(p.x / 2, 1), p.y};
  if (layout == Layout::kTopBottom) return {p.x, std::max(p.y / 2, 1)};
  return p;
}

ivec2 eye_pixels_in(Layout layout, const ivec2& p) {
  const ivec2 twice = screen_pixels(layout, {1, 1});
  return glm::max(p / twice, ivec2(1));
}

ivec2 screen_pixels(Layout layout, const ivec2& p) {
  switch (layout) {
    case Layout::kSideBySide:
    case Layout::kTwoOutputs:
      return {2 * p.x, p.y};
    case Layout::kTopBottom:
    case Layout::kFrameSequential:
      return {p.x, 2 * p.y};
    case Layout::kMono:
    case Layout::kRowInterleaved:
    case Layout::kAnaglyph:
      break;
  }
  return p;
}

}  // namespace typodont::display
