// Screen, mirror, eyes and haptic base in W, and the frusta from them. Pure functions, any thread. E: one eye, x right
// and y up of the picture, which lies at negative z. Clip space: Vulkan's.
#pragma once

#include <array>
#include <filesystem>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <string_view>

#include "engine/base/json.h"
#include "engine/base/pose.h"

namespace typodont::display {

using glm::dmat2;
using glm::dmat4;
using glm::dvec2;
using glm::ivec2;

enum class DisplayKind { kWindow, kMirror, kHmd, kOffscreen };
enum class Layout { kMono, kSideBySide, kTopBottom, kRowInterleaved, kAnaglyph, kTwoOutputs, kFrameSequential };
std::string_view name_of(DisplayKind kind) noexcept;
std::string_view name_of(Layout layout) noexcept;

/// The physical panel. Its corners are named for the upright picture.
struct Screen {
  /// m, frame W, three corners of the panel
  dvec3 lower_left{-0.26, -0.145, 0}, lower_right{0.26, -0.145, 0}, upper_left{-0.26, 0.145, 0};
  ivec2 pixels{1920, 1080};
  Layout layout = Layout::kSideBySide;
};

/// normal · p = offset in W. Glass displaces the hand's image; glass_shift displaces the picture alike.
struct Mirror {
  dvec3 normal{0, 1, 0};       // unit normal vector of the plane, in frame W
  double offset = 0;           // m along the normal
  double glass_thickness = 0;  // m, thickness of the glass plate in front of the hand
  double glass_index = 1.52;
};

struct Head {
  dvec3 eye_center{0, 0, 0.6};  // m, frame W, midpoint between the eyes
  double ipd = 0.063;           // m, distance between the user's eyes (interpupillary distance)
  dvec3 right{1, 0, 0};         // unit vector from the left eye to the right eye
  std::string tracker;          // address "opentrack:PORT" (head_tracker.h); empty: the head does not move
};

/// D: x right, y up, view along −z.
struct HmdRig {
  // STAGE, else LOCAL (origin at the seat)
  bool stage = true;
  // For example measured with an arm; empty: tissue in front of the user.
  std::optional<Pose> X_WD;
  double magnify = 1;  // only without X_WD; scales the hand, too
  /// m in front of and below the eyes; without X_WD
  double distance = 0.35, below = 0.22;
  bool passthrough = false;  // shows the room, if supported
  bool depth = true;         // true: passes the picture's depth to the headset's runtime, if accepted
  double refresh_hz = 0;     // Hz, refresh rate of the headset; 0: its runtime chooses
  double resolution = 1;     // factor by which the headset runtime's recommended size is multiplied
  double wait = 15;          // s, time limit for the user to put the headset on
  double stall = 3;          // s without an answer: the session ends
  dvec3 tip{0, 0, -0.06};    // m, position of the tool's head in the controller's aim frame
};

struct DisplayRig {
  DisplayKind kind = DisplayKind::kOffscreen;
  Screen screen;
  std::optional<Mirror> mirror;
  Head head;
  Pose X_WH;       // pose of the haptic base (frame H) in frame W
  Pose left_X_WH;  // base of the second hand's device
  // devices by address and serial number, "woodenhaptics:1234567"; empty: not specified
  std::string hand, left_hand, pedal;
  double pedal_limit = 0;  // s pressed without a break; 0: default
  HmdRig hmd;              // settings for a headset
  double magnify = 1;      // magnification of the picture, see magnified()
  /// m, W, fixed; empty: middle of the tissue
  std::optional<dvec3> magnify_about;
  // rig / bench; below 1 after magnified()
  double scale = 1;
};

/// Screen, mirror and eyes `rig.magnify` times nearer to `rig.magnify_about` (else `about`; m, W). The haptic base
/// stays, so hand and picture agree only there.
DisplayRig magnified(const DisplayRig& rig, const dvec3& about);

/// docs/interface.md. Throws Error.
DisplayRig load_rig(const std::filesystem::path& file);
DisplayRig parse_rig(const Json& json);

struct ClipRange {
  double near = 0.1;  // m along the picture's normal
  double far = 2.0;   // m along the picture's normal
};

/// Cross-section of the frustum with the near plane; m, frame E.
struct Frustum {
  double left = 0, right = 0, bottom = 0, top = 0, near = 0, far = 0;
};

/// View and projection of one eye.
struct EyeView {
  dvec3 position{0, 0, 0};  // m, frame W, position of the eye
  dmat4 view{1.0};          // W to E, m; determinant −1 if `flip`
  dmat4 projection{1.0};    // maps E to Vulkan's clip space
  Frustum frustum;
  bool flip = false;  // in a mirror: front faces reversed
};

/// y up, depth −1..1, as in the literature.
dmat4 opengl_projection(const Frustum& frustum);
/// Returns the projection in Vulkan's clip space (y down, depth 0..1).
dmat4 vulkan_projection(const Frustum& frustum);

/// p − 2 (n·p − c) n; its own inverse.
dvec3 reflect(const Mirror& mirror, const dvec3& p);
dmat4 reflection(const Mirror& mirror);
/// Returns the mirror image of the panel.
Screen reflect(const Mirror& mirror, const Screen& screen);

/// m, W, for the ray from p_WC to the picture's middle, the same for both eyes (separate ones would shift rows). Error
/// at most 0.05 mm at 1 cm, through 3 mm at 45°.
dvec3 glass_shift(const Screen& screen, const Mirror& mirror, const dvec3& p_WC);

/// Kooima 2009, from the eye at p_WE to the screen or its mirror image; `shift`: glass_shift(). Throws Error from
/// behind.
EyeView eye_view(const Screen& screen, const std::optional<Mirror>& mirror, const dvec3& p_WE, const ClipRange& range,
                 const dvec3& shift = dvec3(0));

/// Both in the middle for mono.
std::array<dvec3, 2> eye_positions(const Head& head, Layout layout);
/// Both at least 5 cm in front.
bool sees(const DisplayRig& rig, const Head& head) noexcept;
/// 0.1 and 2 m, adapted to pictures nearer than 0.2 m or beyond 1 m.
ClipRange clip_range(const DisplayRig& rig);
/// Returns the views of the left and the right eye.
std::array<EyeView, 2> eye_views(const DisplayRig& rig);

/// Columns: the user's right and up in the picture, ±1 or 0; a mirror reverses one axis.
dmat2 upright(const DisplayRig& rig);

/// Row-major, mm, as in frame.json.
std::array<double, 16> row_major_mm(const dmat4& view);
std::array<double, 16> row_major_mm_projection(const Frustum& frustum);

/// Pixels: one eye of a screen; the composed screen of an eye.
ivec2 eye_pixels(Layout layout, const ivec2& screen_pixels);
ivec2 screen_pixels(Layout layout, const ivec2& eye_pixels);
/// Inverse of screen_pixels().
ivec2 eye_pixels_in(Layout layout, const ivec2& composed_pixels);

}  // namespace typodont::display
