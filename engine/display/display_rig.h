// Where the screen, the mirror, the eyes and the haptic base are in the workbench frame W, and the asymmetric frusta
// that follow. Pure functions of measured positions: nothing here knows Vulkan objects. Any thread.
//
// Frames: W workbench. E one eye's frame: origin in the eye, x along the picture's right edge-to-edge direction, y
// along its up direction, the picture in front at negative z. Clip space is Vulkan's: x right, y down, depth 0..1.
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

/// The physical panel; its corners as its picture is upright.
struct Screen {
  dvec3 lower_left{-0.26, -0.145, 0}, lower_right{0.26, -0.145, 0}, upper_left{-0.26, 0.145, 0};  // m, W
  ivec2 pixels{1920, 1080};
  Layout layout = Layout::kSideBySide;
};

/// A half mirror: the plane normal · p = offset, in W. The glass is optional: its thickness and refractive index move
/// what is seen through it (the hand) towards the eyes, and the picture follows (glass_shift).
struct Mirror {
  dvec3 normal{0, 1, 0};       // unit
  double offset = 0;           // m
  double glass_thickness = 0;  // m, of the plate the hand is seen through
  double glass_index = 1.52;
};

struct Head {
  dvec3 eye_center{0, 0, 0.6};  // m, W, half-way between the eyes
  double ipd = 0.063;           // m
  dvec3 right{1, 0, 0};         // unit, from the left eye to the right
  std::string tracker;          // "opentrack:PORT" (head_tracker.h), or empty: the head does not move
};

/// A headset: where its space D (x right, y up, the user looks along −z) lies in the workbench.
struct HmdRig {
  bool stage = true;         // D is the room's STAGE, else LOCAL, which begins where the user sits
  std::optional<Pose> X_WD;  // measured, e.g. to a haptic arm; nothing: the work is put before the user
  double magnify = 1;        // the work is seen, and the hand moves, this much larger; only where X_WD is not measured
  double distance = 0.35, below = 0.22;  // m from the eyes to the work, where it is put
  bool passthrough = false;              // show the room behind the work, where the headset can
  bool depth = true;                     // hand the depth over where the runtime takes it
  double refresh_hz = 0;                 // 0: the runtime's choice
  double resolution = 1;                 // of the runtime's recommended width and height
  double wait = 15;                      // s for the headset to be put on
  double stall = 3;                      // s without an answer of the runtime before the session ends
  dvec3 tip{0, 0, -0.06};                // m, of the tool's head in the controller's aim frame
};

struct DisplayRig {
  DisplayKind kind = DisplayKind::kOffscreen;
  Screen screen;
  std::optional<Mirror> mirror;
  Head head;
  Pose X_WH;                           // the haptic base
  Pose left_X_WH;                      // that of the second hand's device
  std::string hand, left_hand, pedal;  // devices by address and serial, "woodenhaptics:1234567"; empty: not named
  double pedal_limit = 0;              // s that the pedal may be held without a break; 0: what is usual
  HmdRig hmd;                          // of a headset
  double magnify = 1;                  // the work is seen so many times larger than life: magnified()
  std::optional<dvec3> magnify_about;  // m, W: what stays where it is; nothing: the work's middle
  double scale = 1;                    // lengths of screen, mirror and eyes in units of those on the bench
};

/// The rig whose picture shows the work `rig.magnify` times larger about `rig.magnify_about`, or about `about` (m, W)
/// where the rig names no point: screen, mirror and eyes shrunk so many times towards it, which is the same picture.
/// The hand's base is not moved: what is seen and what is felt coincide at that point alone.
DisplayRig magnified(const DisplayRig& rig, const dvec3& about);

/// Reads a rig file (INTERFACE.md). Throws Error naming file, key, found and expected.
DisplayRig load_rig(const std::filesystem::path& file);
DisplayRig parse_rig(const Json& json);

struct ClipRange {
  double near = 0.1;  // m from the eye, along the picture's normal
  double far = 2.0;   // m
};

/// Cut of the frustum with the near plane, m, in E.
struct Frustum {
  double left = 0, right = 0, bottom = 0, top = 0, near = 0, far = 0;
};

/// How one eye sees the picture.
struct EyeView {
  dvec3 position{0, 0, 0};  // m, W
  dmat4 view{1.0};          // W → E, m; determinant −1 when flip
  dmat4 projection{1.0};    // E → Vulkan clip space
  Frustum frustum;
  bool flip = false;  // the picture is seen in a mirror: front faces wind the other way
};

/// The worked form of the papers, OpenGL's clip space (y up, depth −1..1): what frusta are compared with.
dmat4 opengl_projection(const Frustum& frustum);
/// The same for Vulkan's clip space (y down, depth 0..1).
dmat4 vulkan_projection(const Frustum& frustum);

/// Reflection in the plane: p ↦ p − 2 (n·p − c) n. Its own inverse.
dvec3 reflect(const Mirror& mirror, const dvec3& p);
dmat4 reflection(const Mirror& mirror);
/// The panel as it stands behind the mirror.
Screen reflect(const Mirror& mirror, const Screen& screen);

/// m, W: how far a half mirror's glass moves what is seen through it, for the ray from p_WC, half-way between the eyes,
/// to the middle of the picture, where the work is. One shift for both eyes, so that points stay in their rows (an
/// eye's own would take them out of them by what refraction itself does, hundredths of a pixel); through 3 mm of glass
/// at 45 degrees what lies a centimetre off the middle is drawn within 0.05 mm of where its own ray shows it.
dvec3 glass_shift(const Screen& screen, const Mirror& mirror, const dvec3& p_WC);

/// Kooima 2009, generalised perspective projection, from the eye at p_WE to the screen, seen in the mirror if there is
/// one (real eye, reflected screen). Throws Error when the eye lies behind the picture or in its plane.
/// `shift`: of what is seen, as glass_shift has it.
EyeView eye_view(const Screen& screen, const std::optional<Mirror>& mirror, const dvec3& p_WE, const ClipRange& range,
                 const dvec3& shift = dvec3(0));

/// Positions of the left and right eye, or of the point half-way between them twice when the layout is mono.
std::array<dvec3, 2> eye_positions(const Head& head, Layout layout);
/// True when both of the head's eyes lie in front of the picture, 5 cm or more.
bool sees(const DisplayRig& rig, const Head& head) noexcept;
/// Near and far planes around the workspace: the worked 0.1 m and 2 m unless the picture is nearer or farther.
ClipRange clip_range(const DisplayRig& rig);
/// Left, right.
std::array<EyeView, 2> eye_views(const DisplayRig& rig);

/// How flat writing must be drawn in the picture so that the user reads it upright: columns are the user's right and
/// up in the picture's (right, up), each ±1 or 0. In a mirror exactly one axis is reversed.
dmat2 upright(const DisplayRig& rig);

/// 16 numbers, row-major, for lengths in mm: what frame.json holds.
std::array<double, 16> row_major_mm(const dmat4& view);
std::array<double, 16> row_major_mm_projection(const Frustum& frustum);

/// Pixels of one eye's picture for a screen of these pixels, and of the composed screen for such an eye picture.
ivec2 eye_pixels(Layout layout, const ivec2& screen_pixels);
ivec2 screen_pixels(Layout layout, const ivec2& eye_pixels);
/// The other way round: pixels of one eye's picture in a composed screen of this size.
ivec2 eye_pixels_in(Layout layout, const ivec2& composed_pixels);

}  // namespace typodont::display
