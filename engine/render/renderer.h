// Draws the workbench for both eyes: tissue bricks, tool, particles, static surroundings. Render thread owns
// it. Two eyes in one pass (multiview) into a two-layer picture that a display composes and shows (engine/display).
//
// Only what is needed: what a frame does not hold is not drawn, has no pipeline and loads no shader; a frame equal to
// the last one is not drawn again. FrameStats counts it all.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/mouth_mirror.h"
#include "engine/contract/tissue.h"
#include "engine/gpu/device.h"
#include "engine/gpu/resources.h"
#include "engine/render/particle_cloud.h"
#include "engine/render/quality.h"
#include "engine/render/tool_mesh.h"

namespace typodont::render {

/// One corner of a surface. All corners of a triangle name the same two tissues; the boundary between them is drawn
/// where the interpolated `second` passes one half, crisp within the triangle.
struct Vertex {
  glm::vec3 p{0};        // m, relative to the mesh's origin
  glm::vec3 n{0, 0, 1};  // unit, out of the tissue
  std::array<Tissue, 2> tissue{Tissue::kEnamel, Tissue::kEnamel};
  float second = 0;             // 0..1: share of tissue[1]
  Tissue under = Tissue::kAir;  // what lies beneath the tissue at the surface …
  float shows = 0;              // … and how much of its colour shows through, 0..1
  float difference = 0;         // m, still to remove (> 0) or should have stayed (< 0), for View::kDifference
};

/// A piece of a mesh: what a brick looks like now. Empty: nothing is left of it.
struct MeshUpdate {
  std::uint64_t brick = 0;  // any number, unique in its mesh
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;  // triangles, counter-clockwise seen from outside
  bool two_sided = false;              // of a surface with a border: its back is drawn too, dull and blue-grey
};

/// A body made of bricks: the working tooth, gingiva, a neighbour.
using MeshId = std::uint32_t;
inline constexpr MeshId kWorkingTooth = 0;
// Bodies that only one view shows.
inline constexpr MeshId kSectionFace = 1000, kSectionFaceAround = 1001;                  // View::kSection
inline constexpr MeshId kInsidePulp = 1002, kInsideCaries = 1003, kInsideDentin = 1004;  // View::kXray

/// How the scene is shown: as it looks, or for teaching.
enum class View {
  kLook,
  kSection,     // tissue only where section · (p, 1) > 0, with the faces cut through the bodies
  kXray,        // the working tooth as glass, with the tissues inside it; nothing around it
  kDifference,  // the working tooth against an ideal: blue still to remove, red should have stayed (Vertex::difference)
};

struct Eye {
  glm::dmat4 view{1.0};        // W → eye, m
  glm::dmat4 projection{1.0};  // Vulkan clip space
  dvec3 position{0, 0, 0};     // m, W
  bool flip = false;           // seen in a mirror
};

struct Particle {
  glm::vec3 p{0};        // m, W
  float radius = 2e-5f;  // m
  glm::vec3 color{1};    // sRGB
  float opacity = 1;     // 1 a chip, less: mist
};

struct ToolState {
  bool visible = false;
  Pose X_WG;           // as held outside the tissue
  double angle = 0;    // rad about its z
  double spindle = 0;  // rad/s: how much the flutes blur
  double opacity = 1;  // less: sieved, as when the hand that holds it is out of sight
};

/// Where a tool that moves on along its line meets what is drawn: a ring is drawn there. Depth can be judged by it in a
/// mono picture.
struct Cursor {
  bool visible = false;
  dvec3 p{0};            // m, W: where the line begins
  dvec3 down{0, 0, -1};  // unit, W: along the line
  double radius = 1e-3;  // m, of the ring
};

/// Lights are given in W and so need no mirroring.
struct Lights {
  dvec3 key{-0.35, 0.55, 0.75};  // unit, towards the lamp
  dvec3 up{0, 1, 0};             // unit, towards the ceiling
  dvec3 window{0, 0, 0};         // unit, towards the window that gloss mirrors; zero: beside the lamp
  double key_strength = 2.5;
  double ambient = 0.50;
};

/// A half mirror wants black: it is where the hand shows. Clear is black of opacity 0: there a headset shows the room.
enum class Background { kGradient, kBlack, kClear };

struct Frame {
  std::array<Eye, 2> eyes;
  int views = 2;  // 1: mono
  ToolState tool;
  Cursor cursor;
  MouthMirror mirror;  // in the other hand; diameter 0: none
  View view = View::kLook;
  glm::dvec4 section{0, 0, 0, 1};  // xyz: unit normal, W, w: m; for View::kSection
  std::span<const Particle> particles;
  ParticleCloud* cloud = nullptr;  // particles that live on the GPU: moved by as much as was asked, and drawn
  Lights lights;
  Background background = Background::kGradient;
};

/// Pixels of a picture.
struct PixelBox {
  int x = 0, y = 0, width = 0, height = 0;
  bool operator==(const PixelBox&) const = default;
};

struct FrameStats {
  bool drawn = false;        // false: nothing had changed, no commands recorded
  std::uint64_t frames = 0;  // drawn since the start
  int views = 0;
  double redrawn = 1;  // share of the pictures; the rest is as the last frame left it
  int bricks_drawn = 0, bricks_culled = 0, bricks_facing_away = 0, bricks_covered = 0;
  int bricks_unchanged = 0;  // in view, but only in the part that stays
  std::uint64_t triangles = 0;
  int passes = 0;           // render passes recorded
  int commands = 0;         // draw calls recorded
  int bricks_uploaded = 0;  // since the last frame
  std::uint64_t bytes_uploaded = 0;
  int pipelines = 0;  // alive
  double pixel = 0;   // m: what a pixel drawn covers of the working tooth where that is nearest to an eye; 0: no tooth
  // The scene once more, as the mouth mirror shows it: passes of `passes`, drawn only where an eye sees the glass.
  int mirror_passes = 0, mirror_bricks = 0;
  std::uint64_t mirror_triangles = 0;
  double gpu_ms = 0;  // of the last finished frame; 0 where the device has no timestamps
};

class Renderer {
 public:
  /// Set-up; throws Error. `size` is one eye's picture.
  Renderer(gpu::Device& device, glm::ivec2 size, const Quality& quality, const MaterialTable& materials);
  ~Renderer();
  Renderer(Renderer&&) noexcept;

  /// Uploads the bricks given; all others stay as they are.
  void update(MeshId mesh, std::span<const MeshUpdate> bricks);
  void place(MeshId mesh, const Pose& X_WM);
  void remove(MeshId mesh);
  /// Of the mesh's first bricks those wholly where dot(beyond, (p_W, 1)) < 0 lie within another body: View::kLook and
  /// kDifference do not draw them until they change. Zero: none.
  void cover(MeshId mesh, const glm::dvec4& beyond);
  void set_tool(const ToolMesh& tool);
  void resize(glm::ivec2 size);
  void set_quality(const Quality& quality);
  /// Triangles of each eye's picture that nobody sees (behind a headset's lenses): nothing is drawn there. x, y: clip
  /// space of the picture; z: the eye.
  void set_hidden(std::span<const glm::vec3> corners);
  /// From now on depth() holds each frame's depth: a headset's compositor asks for it.
  void keep_depth(bool keep);

  /// Records the frame unless it is the same as the last one; the caller submits. `slot` is the frame in flight.
  FrameStats record(VkCommandBuffer commands, const Frame& frame, int slot, std::uint64_t submitted,
                    std::uint64_t finished);

  /// The eyes' pictures: two layers (one when mono), sRGB bytes, ready to be sampled or copied after record().
  const gpu::Image& pictures() const;
  /// What of an eye's picture the last record() drew anew.
  std::span<const PixelBox> redrawn(int view) const;
  /// An eye's depth, D32, as a copy's source after record(); only where it is kept.
  struct DepthPicture {
    const gpu::Image* image = nullptr;
    std::uint32_t layer = 0;
  };
  DepthPicture depth(int view) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace typodont::render
