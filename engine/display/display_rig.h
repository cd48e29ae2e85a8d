// Screen, mirror, eyes and haptic base in W, and the frusta computed from them. Any thread. Frame E of an eye: x right,
// y up; the picture is at negative z. Clip space as in Vulkan.
#pragma once

#include <array>
#include <filesystem>
#include <glm/glm.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/arm_geometry.h"
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

/// The physical panel; corners are named for the upright picture.
struct Screen {
  /// Three corners of the panel, m, frame W.
  dvec3 lower_left{-0.26, -0.145, 0}, lower_right{0.26, -0.145, 0}, upper_left{-0.26, 0.145, 0};
  ivec2 pixels{1920, 1080};
  Layout layout = Layout::kSideBySide;
  dvec3 bow{0};  // m, bend of the panel (engine/base/line_of_sight.h, Panel)
};

/// A mirror in the plane normal · p = offset (frame W). The glass displaces the image of the hand; glass_shift()
/// displaces the picture by the same amount.
struct Mirror {
  dvec3 normal{0, 1, 0};       // unit normal vector of the plane, in frame W
  double offset = 0;           // m, distance of the plane from W's origin along the normal
  double glass_thickness = 0;  // m, thickness of the glass in front of the hand
  double glass_index = 1.52;
  // The mirror is curved about its point nearest to `middle` (m): engine/base/line_of_sight.h, Mirror; 1/m.
  dvec3 middle{0}, curvature{0};
};

struct Head {
  dvec3 eye_center{0, 0, 0.6};  // m, frame W, midpoint between the eyes
  double ipd = 0.063;           // m, distance between the user's eyes (interpupillary distance)
  dvec3 right{1, 0, 0};         // unit vector from the left eye to the right eye
  std::string tracker;          // address "opentrack:PORT" (head_tracker.h); empty: the head does not move
};

/// Settings of a headset. Frame D: x right, y up, the user looks along −z.
struct HmdRig {
  // Reference space of OpenXR: true: STAGE (room), false: LOCAL (origin at the user's seat).
  bool stage = true;
  // Pose of the headset's space D in W, measured for example with an arm; empty: the tissue is in front of the user.
  std::optional<Pose> X_WD;
  double magnify = 1;  // magnification, which scales the hand's motion too; used only if X_WD is empty
  /// Distance of the tissue in front of and below the eyes, m; used only if X_WD is empty.
  double distance = 0.35, below = 0.22;
  bool passthrough = false;  // shows the room behind the scene, if supported
  bool depth = true;         // true: passes the picture's depth to the runtime, if accepted
  double refresh_hz = 0;     // Hz, refresh rate of the headset; 0: its runtime chooses
  double resolution = 1;     // factor by which the headset runtime's recommended size is multiplied
  double wait = 15;          // s, time limit for putting the headset on
  double stall = 3;          // s, time without an answer of the headset's runtime, after which the session ends
  dvec3 tip{0, 0, -0.06};    // m, position of the tool's head in the controller's aim frame
};

struct DisplayRig {
  DisplayKind kind = DisplayKind::kOffscreen;
  Screen screen;
  std::optional<Mirror> mirror;
  Head head;
  Pose X_WH;                       // pose of the haptic base (frame H) in frame W
  std::optional<ArmGeometry> arm;  // measured geometry of the hand's arm; empty: that of the device's preset
  Pose left_X_WH;                  // pose of the base of the second hand's device in frame W
  // Addresses of devices with serial number, "woodenhaptics:1234567"; empty: not specified.
  std::string hand, left_hand, pedal;
  double pedal_limit = 0;  // s, largest time that a pedal may be pressed without a break; 0: default
  HmdRig hmd;              // settings for a headset
  double magnify = 1;      // magnification of the picture, see magnified()
  /// Centre of the magnification, m, frame W; empty: middle of the tissue.
  std::optional<dvec3> magnify_about;
  // Length in this rig divided by the length of the real screen, mirror or glass; magnified() makes it smaller than 1.
  double scale = 1;
};

/// Moves screen, mirror and eyes towards a centre, so that they are nearer by the
/// factor `rig.magnify`. Centre: `rig.magnify_about`, or else `about` (m, frame W).
/// The haptic base does not move, so hand and picture agree only at the centre.
DisplayRig magnified(const DisplayRig& rig, const dvec3& about);

/// Reads a rig (docs/interface.md). Throws Error.
DisplayRig load_rig(const std::filesystem::path& file);
DisplayRig parse_rig(const Json& json);
void describe_rig(Keys& keys, DisplayRig& rig);

struct ClipRange {
  double near = 0.1;  // m, distance of the near plane along the picture's normal
  double far = 2.0;   // m, distance of the far plane along the picture's normal
};

/// Cross-section of the frustum at the near plane, m, frame E.
struct Frustum {
  double left = 0, right = 0, bottom = 0, top = 0, near = 0, far = 0;
};

/// View and projection of one eye.
struct EyeView {
  dvec3 position{0, 0, 0};  // m, frame W, position of the eye
  dmat4 view{1.0};          // maps frame W to frame E, m; determinant −1 if `flip`
  dmat4 projection{1.0};    // maps the eye's frame E to Vulkan's clip space
  Frustum frustum;
  bool flip = false;  // true in a mirror: reverses the winding of front faces
};

/// Projection with y up and depth −1..1, as in OpenGL.
dmat4 opengl_projection(const Frustum& frustum);
/// Projection to Vulkan's clip space (y down, depth 0..1).
dmat4 vulkan_projection(const Frustum& frustum);

/// Mirror image of p: p − 2 (n·p − c) n. The function is its own inverse.
dvec3 reflect(const Mirror& mirror, const dvec3& p);
dmat4 reflection(const Mirror& mirror);
/// Returns the mirror image of the panel.
Screen reflect(const Mirror& mirror, const Screen& screen);

/// Shift by the glass for the ray from p_WC (midpoint of the eyes) to the picture's middle, m, frame W; used for both
/// eyes. Error: at most 0.05 mm at 1 cm behind 3 mm of glass at 45°.
dvec3 glass_shift(const Screen& screen, const Mirror& mirror, const dvec3& p_WC);

/// View of the eye at p_WE through the screen, or its mirror image (Kooima 2009). `shift`: result of glass_shift().
/// Throws Error if the eye is behind the screen.
EyeView eye_view(const Screen& screen, const std::optional<Mirror>& mirror, const dvec3& p_WE, const ClipRange& range,
                 const dvec3& shift = dvec3(0));

/// Positions of both eyes; for a mono picture, both positions are the midpoint of the eyes.
std::array<dvec3, 2> eye_positions(const Head& head, Layout layout);
/// Returns true if both eyes are at least 5 cm in front of the screen.
bool sees(const DisplayRig& rig, const Head& head) noexcept;
/// Near and far plane: 0.1 and 2 m, adapted to pictures nearer than 0.2 m or farther than 1 m.
ClipRange clip_range(const DisplayRig& rig);
/// Returns the views of the left and the right eye.
std::array<EyeView, 2> eye_views(const DisplayRig& rig);

/// The pictures of a bent panel or mirror, for each eye: place in the eye's picture (0..1 from its left and upper edge)
/// whose colour the panel must show, at kWarpSide × kWarpSide places of the panel, row by row from its upper left
/// corner.
using Warp = std::array<std::vector<glm::vec2>, 2>;
inline constexpr int kWarpSide = 33;
/// Empty if panel and mirror are plane.
std::optional<Warp> warp(const DisplayRig& rig);

/// Columns: the user's right and up in coordinates of the picture, ±1 or 0; a mirror reverses one axis.
dmat2 upright(const DisplayRig& rig);

/// Converts a matrix to row-major order with lengths in mm, as in frame.json.
std::array<double, 16> row_major_mm(const dmat4& view);
std::array<double, 16> row_major_mm_projection(const Frustum& frustum);

/// eye_pixels(): size of an eye's picture on a screen of this size, pixels. screen_pixels(): the inverse function.
ivec2 eye_pixels(Layout layout, const ivec2& screen_pixels);
ivec2 screen_pixels(Layout layout, const ivec2& eye_pixels);
/// Size of an eye's picture in a composed screen; inverse of screen_pixels().
ivec2 eye_pixels_in(Layout layout, const ivec2& composed_pixels);

}  // namespace typodont::display
