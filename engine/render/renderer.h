// Draws the workbench for both eyes in one pass (multiview) into two layers, which engine/display shows. Render thread
// only. What a frame lacks has no pipeline and no shader; an equal frame is not drawn again. Overview and terms:
// README.md.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engine/base/pose.h"
#include "engine/contract/mouth_mirror.h"
#include "engine/contract/suction_tip.h"
#include "engine/contract/tissue.h"
#include "engine/gpu/device.h"
#include "engine/gpu/resources.h"
#include "engine/render/handpiece_mesh.h"
#include "engine/render/particle_cloud.h"
#include "engine/render/quality.h"
#include "engine/render/shared.h"
#include "engine/render/tool_mesh.h"

namespace typodont::render {

/// A triangle's corners store the same two tissues; the border is where `second` is one half.
struct Vertex {
  glm::vec3 p{0};        // m, position relative to the mesh's origin
  glm::vec3 n{0, 0, 1};  // unit normal, pointing out of the tissue
  std::array<Tissue, 2> tissue{Tissue::kEnamel, Tissue::kEnamel};
  float second = 0;             // 0..1, fraction of the second tissue, tissue[1]
  Tissue under = Tissue::kAir;  // the tissue below the surface tissue
  float shows = 0;              // 0..1, of the lower tissue's colour
  float depth = 0;              // m, of the lower tissue
  float cut = 0;                // 0..1, of the surface around
  float thin = 0;               // 0..1; 0: thicker than kTranslucentThickness
  float lesion = 0;             // 0..1, nearness of caries; 0: farther than kLesionReach
  float difference = 0;         // m to remove (> 0) or too much (< 0), for View::kDifference
};

/// m; thicker tissue lets no light through
inline constexpr double kTranslucentThickness = 1.6e-3;
/// m; caries discolours sound tissue up to here
inline constexpr double kLesionReach = 0.8e-3;

/// A brick's content now; empty removes it.
struct MeshUpdate {
  std::uint64_t brick = 0;  // unique in the mesh
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;  // triangles, counter-clockwise seen from outside
  bool two_sided = false;              // open surface: its back is dull blue-grey
};

/// A body of bricks: working tooth, gingiva, a neighbour.
using MeshId = std::uint32_t;
inline constexpr MeshId kWorkingTooth = 0;
// In one view only.
inline constexpr MeshId kSectionFace = 1000, kSectionFaceAround = 1001;                  // shown only in View::kSection
inline constexpr MeshId kInsidePulp = 1002, kInsideCaries = 1003, kInsideDentin = 1004;  // shown only in View::kXray

/// Realistic, or for teaching.
enum class View {
  kLook,
  kSection,  // section · (p, 1) > 0 only, with cut faces
  kXray,     // working tooth as glass, with its insides; nothing else
  // working tooth against the ideal (Vertex::difference): blue must go, red is too much
  kDifference,
};

struct Eye {
  glm::dmat4 view{1.0};        // m, W to the eye
  glm::dmat4 projection{1.0};  // maps the eye's frame to Vulkan's clip space
  dvec3 position{0, 0, 0};     // m, frame W, position of the eye
  bool flip = false;           // seen in a mirror
};

struct Particle {
  glm::vec3 p{0};        // m, frame W, position of the particle
  float radius = 2e-5f;  // m, radius of the particle
  glm::vec3 color{1};    // sRGB, colour of the particle
  float opacity = 1;     // 1 for a chip, less for mist
  glm::vec3 streak{0};   // m, W: a droplet's way during the exposure, ending at p
};

/// lo to hi inclusive; empty by default.
struct CellBox {
  glm::ivec3 lo{std::numeric_limits<int>::max()}, hi{std::numeric_limits<int>::min()};
  bool empty() const { return lo.x > hi.x || lo.y > hi.y || lo.z > hi.z; }
  void take(const CellBox& other) { lo = glm::min(lo, other.lo), hi = glm::max(hi, other.hi); }
  bool meets(const CellBox& other) const { return !CellBox{glm::max(lo, other.lo), glm::min(hi, other.hi)}.empty(); }
};

/// Of water and slurry on the working tooth; samples at origin + spacing · (x, y, z).
struct FilmGrid {
  dvec3 origin{0};     // m, frame W, position of the first sample
  double spacing = 0;  // m, distance between neighbouring samples
  glm::ivec3 size{0};  // 0: no film
};
/// For shaders/film.glsl. Zero: dry and clean.
struct FilmTexel {
  std::uint8_t water = 0;   // 255 · (1 − exp(−height / 80 µm))
  std::uint8_t cover = 0;   // opacity of the solids, times 255
  std::uint8_t colour = 0;  // solids: 0 enamel, 128 dentin, 255 caries
  std::uint8_t blood = 0;   // fraction of blood in the colour, times 255
  bool operator==(const FilmTexel&) const = default;
};

/// Room and other surfaces, by LightScene; samples at origin + spacing · (x, y, z).
struct LightGrid {
  dvec3 origin{0};     // m, frame W, position of the first sample
  double spacing = 0;  // m, distance between neighbouring samples
  glm::ivec3 size{0};  // 0: no grid
  static constexpr int kFaces = shared::kLightDirections;
  // Facing +x, -x, +y, -y, +z, -z (index()). xyz: irradiance / π, linear; w: visible part of the lamp.
  std::vector<glm::vec4> faces;
  // Mirrored in wet tissue and metal: linear radiance over ±10° around the directions of an octahedral map
  // (image_direction(), light_scene.h); see image_index().
  static constexpr int kImageSide = shared::kImageSide;
  std::vector<glm::vec3> images;

  std::size_t samples() const {
    return static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) * static_cast<std::size_t>(size.z);
  }
  std::size_t index(int face, const glm::ivec3& i) const {
    return ((static_cast<std::size_t>(face) * size.x + static_cast<std::size_t>(i.x)) * size.y +
            static_cast<std::size_t>(i.y)) *
               size.z +
           static_cast<std::size_t>(i.z);
  }
  /// In `images`. Nodes lie along y and z: devices limit an axis.
  std::size_t image_index(const glm::ivec2& node, const glm::ivec3& i) const {
    const auto side = static_cast<std::size_t>(kImageSide), y = static_cast<std::size_t>(size.y),
               z = static_cast<std::size_t>(size.z);
    const std::size_t row = (static_cast<std::size_t>(i.x) * side + static_cast<std::size_t>(node.x)) * y;
    return ((row + static_cast<std::size_t>(i.y)) * side + static_cast<std::size_t>(node.y)) * z +
           static_cast<std::size_t>(i.z);
  }
};

/// Leaves translucent tissue after travelling in it, near the working tooth; cells beside surfaces only. By
/// TissueLight; cells at origin + spacing · (x, y, z).
struct TissueLightGrid {
  dvec3 origin{0};     // m, frame W, position of the first cell
  double spacing = 0;  // m, distance between neighbouring cells
  glm::ivec3 size{0};  // 0: no grid
  // (x·size.y + y)·size.z + z. xyz: leaving light / reflectance, linear, which is irradiance / π under even light on a
  // flat layer or an opaque body; w: part directly from the lamp.
  std::vector<glm::vec4> values;
};

struct ToolState {
  bool visible = false;
  Pose X_WG;           // the servo's proxy, outside the tissue
  double angle = 0;    // rad about z
  double spindle = 0;  // rad/s, for the flutes' motion blur
  double opacity = 1;  // of the pixels; below 1 while the hand is out of sight
  Pose X_GH;           // of the handpiece, if there is one
  bool open = true;    // left out where it hides the working point
};

/// A ring where the tool would meet the scene along `down`, to judge depth in mono.
struct Cursor {
  bool visible = false;
  dvec3 p{0};            // m, W
  dvec3 down{0, 0, -1};  // unit vector, W
  double radius = 1e-3;  // m, radius of the ring
};

/// W, not mirrored.
struct Lights {
  dvec3 key{-0.35, 0.55, 0.75};  // unit vector towards the lamp
  dvec3 up{0, 1, 0};             // unit vector towards the ceiling
  /// unit vector to the reflected window; zero: beside the lamp
  dvec3 window{0, 0, 0};
  double key_strength = 4.0;
  // A spot with a soft border at the working tooth, as a dental lamp's at 0.7 m.
  glm::dvec2 spot{0.15, 0.08};  // m; half brightness at its sides
  double spot_border = 0.025;   // m, from full brightness to zero
  double lamp_width = 0.168;    // m, of the luminous area; for penumbras
  double lamp_distance = 0.7;   // m, from the working tooth
  double ambient = 1.0;         // factor by which the room's light is multiplied
};

/// Unit vector.
dvec3 toward_window(const Lights& lights);

/// kBlack for half mirrors: the hand shows through black. kClear: black with opacity 0, for a headset's room.
enum class Background { kGradient, kBlack, kClear };

struct Frame {
  std::array<Eye, 2> eyes;
  int views = 2;  // number of pictures; 1: mono
  ToolState tool;
  Cursor cursor;
  MouthMirror mirror;  // diameter 0: none
  SuctionTip suction;  // opening 0: none
  View view = View::kLook;
  glm::dvec4 section{0, 0, 0, 1};  // View::kSection: unit normal, W; w: offset, m
  std::span<const Particle> particles;
  ParticleCloud* cloud = nullptr;  // moved and drawn by the renderer
  Lights lights;
  Background background = Background::kGradient;
};

/// Pixels.
struct PixelBox {
  int x = 0, y = 0, width = 0, height = 0;
  bool operator==(const PixelBox&) const = default;
};

struct FrameStats {
  bool drawn = false;        // false: nothing changed, nothing recorded
  std::uint64_t frames = 0;  // number of frames drawn since the start
  int views = 0;
  double redrawn = 1;  // fraction of the pictures that was redrawn
  int bricks_drawn = 0, bricks_culled = 0, bricks_facing_away = 0, bricks_covered = 0;
  int bricks_unchanged = 0;  // in view, but not redrawn
  std::uint64_t triangles = 0;
  int passes = 0;           // number of recorded render passes
  int commands = 0;         // number of recorded draw calls
  int bricks_uploaded = 0;  // since the last frame
  std::uint64_t bytes_uploaded = 0;
  int pipelines = 0;             // number of pipelines that exist now
  std::uint64_t film_bytes = 0;  // uploaded
  double pixel = 0;              // m, of a pixel on the working tooth nearest to an eye; 0: no tooth
  // For the mirror's picture, drawn if an eye sees the glass. `passes` includes mirror_passes.
  int mirror_passes = 0, mirror_bricks = 0;
  std::uint64_t mirror_triangles = 0;
  double gpu_ms = 0;  // of the last finished frame; 0: no timestamps
};

class Renderer {
 public:
  /// `size`: of one eye. May throw Error.
  Renderer(gpu::Device& device, glm::ivec2 size, const Quality& quality, const MaterialTable& materials);
  ~Renderer();
  Renderer(Renderer&&) noexcept;

  /// The others stay.
  void update(MeshId mesh, std::span<const MeshUpdate> bricks);
  void place(MeshId mesh, const Pose& X_WM);
  void remove(MeshId mesh);
  /// Bricks from the start wholly where dot(beyond, (p_W, 1)) < 0 are inside another body: not drawn in kLook and
  /// kDifference until they change. Zero: no plane.
  void cover(MeshId mesh, const glm::dvec4& beyond);
  /// And the handpiece that holds it; without parts: none. Throws Error if it has too many triangles.
  void set_tool(const ToolMesh& tool, const Handpiece& handpiece = {});
  /// Clears the film. Size 0: no film, no time.
  void set_film(const FilmGrid& grid);
  /// `changed` boxes from the whole grid `texels`, index (x·size.y + y)·size.z + z.
  void update_film(std::span<const FilmTexel> texels, std::span<const CellBox> changed);
  /// Room and surfaces, and inside tissue. Size 0: the room's light is estimated from the surface's shape, bodies do
  /// not light each other, `inside` is unused.
  void set_light(const LightGrid& grid, const TissueLightGrid& inside);
  /// `changed` box from the whole grid TissueLightGrid::values.
  void update_tissue_light(std::span<const glm::vec4> values, const CellBox& changed);
  void resize(glm::ivec2 size);
  void set_quality(const Quality& quality);
  /// What a headset's lenses hide. x, y: clip space; z: eye.
  void set_hidden(std::span<const glm::vec3> corners);
  /// For depth(), which a headset's compositor needs.
  void keep_depth(bool keep);

  /// Unless equal to the last frame. The caller submits. `slot`: frame in flight.
  FrameStats record(VkCommandBuffer commands, const Frame& frame, int slot, std::uint64_t submitted,
                    std::uint64_t finished);

  /// Two layers (mono: one), sRGB bytes, ready after record().
  const gpu::Image& pictures() const;
  /// By the last record().
  std::span<const PixelBox> redrawn(int view) const;
  /// D32, in a copy source's layout after record(). Needs keep_depth(true).
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
