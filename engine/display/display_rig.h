// Positions of the screen, the mirror, the eyes and the haptic base in the workbench frame W, and the asymmetric view
// frusta computed from them. Pure functions of measured positions, without Vulkan objects. Any thread.
// Frames: W workbench. E one eye's frame: origin in the eye, x to the picture's right, y to the picture's top; the
// picture lies at negative z. Clip space is Vulkan's: x right, y down, depth 0..1.
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

/// A half mirror: the plane normal · p = offset in W. The thickness and refractive index of the glass are optional.
/// Refraction in the glass displaces the image of the hand towards the eyes. The picture is displaced by the same
/// amount (glass_shift), so that picture and hand still match.
struct Mirror {
  dvec3 normal{0, 1, 0};       // unit normal vector of the plane, in frame W
  double offset = 0;           // m, distance of the plane from the origin of frame W along the normal
  double glass_thickness = 0;  // m, thickness of the glass plate in front of the hand
  double glass_index = 1.52;
};

struct Head {
  dvec3 eye_center{0, 0, 0.6};  // m, frame W, midpoint between the eyes
  double ipd = 0.063;           // m, distance between the user's eyes (interpupillary distance)
  dvec3 right{1, 0, 0};         // unit vector from the left eye to the right eye
  std::string tracker;          // address "opentrack:PORT" (head_tracker.h); empty: the head does not move
};

/// A headset: the pose of its space D (x right, y up, the user looks along −z) in the workbench.
struct HmdRig {
  // true: D is the room's STAGE space; false: D is the LOCAL space, with its origin at the user's seat
  bool stage = true;
  // Pose of the headset's frame D in frame W, for example measured relative to a haptic arm. If there is none, the
  // tissue is placed in front of the user.
  std::optional<Pose> X_WD;
  double magnify = 1;  // magnification of the picture and of the hand's motion; only if X_WD is not measured
  /// m, position of the tissue: distance in front of the eyes, and below the eyes; used only if X_WD is not measured
  double distance = 0.35, below = 0.22;
  bool passthrough = false;  // true: shows the room behind the tissue, if the headset supports this
  bool depth = true;         // true: passes the picture's depth to the headset's runtime, if accepted
  double refresh_hz = 0;     // Hz, refresh rate of the headset; 0: its runtime chooses
  double resolution = 1;     // factor by which the headset runtime's recommended size is multiplied
  double wait = 15;          // s, time limit for the user to put the headset on
  double stall = 3;          // s, if the headset's runtime does not answer for this time, the session ends
  dvec3 tip{0, 0, -0.06};    // m, position of the tool's head in the controller's aim frame
};

struct DisplayRig {
  DisplayKind kind = DisplayKind::kOffscreen;
  Screen screen;
  std::optional<Mirror> mirror;
  Head head;
  Pose X_WH;       // pose of the haptic base (frame H) in frame W
  Pose left_X_WH;  // pose of the base of the second hand's device in frame W
  // devices by address and serial number, "woodenhaptics:1234567"; empty: not specified
  std::string hand, left_hand, pedal;
  double pedal_limit = 0;  // s, the pedal may be pressed for this time without a break; 0: the default time
  HmdRig hmd;              // settings for a headset
  double magnify = 1;      // magnification of the picture, see magnified()
  /// m, frame W: the fixed point of the magnification; no value: the middle of the tissue that is worked on
  std::optional<dvec3> magnify_about;
  // Ratio of the distances between screen, mirror and eyes in this rig to the measured distances on the bench. It is
  // less than 1 if magnified() has reduced the distances.
  double scale = 1;
};

/// Returns a rig whose picture shows the scene `rig.magnify` times larger. The fixed point of the magnification is
/// `rig.magnify_about`, or `about` (m, frame W) if the rig has none. All distances of screen, mirror and eyes from the
/// fixed point are divided by the magnification; this gives the magnified picture. The haptic base does not move, so
/// the visual and the haptic position agree only at the fixed point.
DisplayRig magnified(const DisplayRig& rig, const dvec3& about);

/// Reads a rig file (docs/interface.md). Throws Error with the file, the key, the value that was found, and the value
/// that was expected.
DisplayRig load_rig(const std::filesystem::path& file);
DisplayRig parse_rig(const Json& json);

struct ClipRange {
  double near = 0.1;  // m, distance of the near plane from the eye along the picture's normal
  double far = 2.0;   // m, distance of the far plane from the eye along the picture's normal
};

/// Cross-section of the frustum with the near plane; m, frame E.
struct Frustum {
  double left = 0, right = 0, bottom = 0, top = 0, near = 0, far = 0;
};

/// View and projection of one eye.
struct EyeView {
  dvec3 position{0, 0, 0};  // m, frame W, position of the eye
  dmat4 view{1.0};          // maps W to E, m; the determinant is −1 if `flip` is true
  dmat4 projection{1.0};    // maps E to Vulkan's clip space
  Frustum frustum;
  bool flip = false;  // true if the picture is seen in a mirror; the winding of front faces is then reversed
};

/// Returns the projection in OpenGL's clip space (y up, depth −1..1), as in the literature; for comparison.
dmat4 opengl_projection(const Frustum& frustum);
/// Returns the projection in Vulkan's clip space (y down, depth 0..1).
dmat4 vulkan_projection(const Frustum& frustum);

/// Returns the reflection of p in the mirror's plane: p ↦ p − 2 (n·p − c) n (n: normal, c: offset). The reflection is
/// its own inverse.
dvec3 reflect(const Mirror& mirror, const dvec3& p);
dmat4 reflection(const Mirror& mirror);
/// Returns the mirror image of the panel.
Screen reflect(const Mirror& mirror, const Screen& screen);

/// Returns the displacement (m, frame W) of an object behind the half mirror's glass. It is computed for the ray from
/// the midpoint p_WC between the eyes to the middle of the picture, where the tissue is. Both eyes use the same
/// displacement, so that corresponding points stay in the same row; separate displacements would shift rows by some
/// hundredths of a pixel. The remaining error is at most 0.05 mm for a point one centimetre off the middle, through 3
/// mm of glass at 45 degrees.
dvec3 glass_shift(const Screen& screen, const Mirror& mirror, const dvec3& p_WC);

/// Returns the generalised perspective projection (Kooima 2009) from the eye at p_WE to the screen. If there is a
/// mirror, the projection is from the real eye to the screen's mirror image. `shift` is the glass_shift() of the
/// picture. Throws Error if the eye lies behind the picture or in its plane.
EyeView eye_view(const Screen& screen, const std::optional<Mirror>& mirror, const dvec3& p_WE, const ClipRange& range,
                 const dvec3& shift = dvec3(0));

/// Returns the positions of the left and right eye. In a mono layout, both are at the midpoint between the eyes.
std::array<dvec3, 2> eye_positions(const Head& head, Layout layout);
/// Returns true if both of the head's eyes are at least 5 cm in front of the picture.
bool sees(const DisplayRig& rig, const Head& head) noexcept;
/// Returns the distances of the near and far planes: 0.1 m and 2 m. If the picture is nearer than 0.2 m, the near plane
/// is nearer, too; if it is farther than 1 m, the far plane is farther, too.
ClipRange clip_range(const DisplayRig& rig);
/// Returns the views of the left and the right eye.
std::array<EyeView, 2> eye_views(const DisplayRig& rig);

/// Returns the orientation in which flat text must be drawn so that the user can read it upright. The columns are the
/// user's right and up directions in picture coordinates (right, up); entries are ±1 or 0. A mirror reverses exactly
/// one axis.
dmat2 upright(const DisplayRig& rig);

/// Returns the matrix as 16 numbers, row-major, with lengths in mm, as in frame.json.
std::array<double, 16> row_major_mm(const dmat4& view);
std::array<double, 16> row_major_mm_projection(const Frustum& frustum);

/// eye_pixels() returns the size (pixels) of one eye's picture for a screen of the given size. screen_pixels() returns
/// the size of the composed screen for an eye's picture of the given size.
ivec2 eye_pixels(Layout layout, const ivec2& screen_pixels);
ivec2 screen_pixels(Layout layout, const ivec2& eye_pixels);
/// Returns the size (pixels) of one eye's picture in a composed screen of the given size. This is the inverse of
/// screen_pixels().
ivec2 eye_pixels_in(Layout layout, const ivec2& composed_pixels);

}  // namespace typodont::display
