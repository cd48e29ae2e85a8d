// Draws the workbench for both eyes in one pass (multiview) into two layers, which engine/display shows. Render thread
// only. A frame equal to the last one is not drawn again. Overview and terms: README.md.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engine/base/pose.h"
#include "engine/base/voxels.h"
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

/// Vertex of a body's surface. All corners of a triangle store the same two tissues; the border between the tissues is
/// where `second` is one half.
struct Vertex {
  glm::vec3 p{0};        // m, position relative to the mesh's origin
  glm::vec3 n{0, 0, 1};  // unit normal, pointing out of the tissue
  std::array<Tissue, 2> tissue{Tissue::kEnamel, Tissue::kEnamel};
  float second = 0;             // 0..1, fraction of the second tissue, tissue[1]
  Tissue under = Tissue::kAir;  // the tissue below the surface tissue
  float shows = 0;              // 0..1, visible fraction of the lower tissue's colour
  float depth = 0;              // m, depth of the tissue `under` below the surface
  float cut = 0;                // 0..1, fraction of cut surface around the vertex
  float thin = 0;               // 0..1, thinness; 0: thicker than kTranslucentThickness
  float lesion = 0;             // 0..1, nearness of caries; 0: farther than kLesionReach
  glm::vec4 paint{0};           // sRGB, colour mixed into the tissue's colour; w: 0..1, fraction of this colour
  float difference = 0;         // m, depth still to remove (> 0) or removed too much (< 0), for View::kDifference
};

/// Thickest tissue that lets light through, m.
inline constexpr double kTranslucentThickness = 1.6e-3;
/// Distance up to which caries discolours sound tissue, m.
inline constexpr double kLesionReach = 0.8e-3;

/// New content of a brick. Without triangles, the brick is removed.
struct MeshUpdate {
  std::uint64_t brick = 0;  // unique in the mesh
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;  // triangles, counter-clockwise seen from outside
  bool two_sided = false;              // open surface; its back is dull blue-grey
};

/// Number of a body of bricks: the working tooth, the gingiva, a neighbouring tooth.
using MeshId = std::uint32_t;
inline constexpr MeshId kWorkingTooth = 0;
// Meshes that only some views show. View::kSection shows the cut faces; kTemperature shows only kSectionFace.
inline constexpr MeshId kSectionFace = 1000, kSectionFaceAround = 1001;
inline constexpr MeshId kInsidePulp = 1002, kInsideCaries = 1003, kInsideDentin = 1004;  // shown only in View::kXray

/// Views: the realistic one, and views for teaching.
enum class View {
  kLook,
  kSection,  // only the part with section · (p, 1) > 0, with cut faces
  kXray,     // the working tooth as glass, with its inside; nothing else
  // Working tooth compared with the ideal shape (Vertex::difference). Blue: still to remove. Red: removed too much.
  kDifference,
  kTemperature,  // the working body alone, cut as in kSection, coloured by TemperatureGrid
};
/// True for the views that show only the part beyond Frame::section.
constexpr bool cuts_section(View view) {
  return view == View::kSection || view == View::kTemperature;
}

struct Eye {
  glm::dmat4 view{1.0};        // maps frame W to the eye's frame, m
  glm::dmat4 projection{1.0};  // maps the eye's frame to Vulkan's clip space
  dvec3 position{0, 0, 0};     // m, frame W, position of the eye
  bool flip = false;           // true: the eye sees through a mirror
};

struct Particle {
  glm::vec3 p{0};        // m, frame W, position of the particle
  float radius = 2e-5f;  // m, radius of the particle
  glm::vec3 color{1};    // sRGB, colour of the particle
  float opacity = 1;     // 1 for a chip, less for mist
  glm::vec3 streak{0};   // m, frame W: path of a droplet during the exposure, which ends at p
};

/// A box of cells, lo to hi inclusive; default empty.
struct CellBox {
  glm::ivec3 lo{std::numeric_limits<int>::max()}, hi{std::numeric_limits<int>::min()};
  bool empty() const { return lo.x > hi.x || lo.y > hi.y || lo.z > hi.z; }
  void take(const CellBox& other) { lo = glm::min(lo, other.lo), hi = glm::max(hi, other.hi); }
  bool meets(const CellBox& other) const { return !CellBox{glm::max(lo, other.lo), glm::min(hi, other.hi)}.empty(); }
};

/// Film of water and slurry on the working tooth; samples at origin + spacing · (x, y, z).
struct FilmGrid {
  dvec3 origin{0};     // m, frame W, position of the first sample
  double spacing = 0;  // m, distance between neighbouring samples
  glm::ivec3 size{0};  // 0: no film
};
/// Sample of the film for shaders/film.glsl. Zero: dry and clean.
struct FilmTexel {
  std::uint8_t water = 0;   // 255 · (1 − exp(−height / 80 µm))
  std::uint8_t cover = 0;   // opacity of the solids, times 255
  std::uint8_t colour = 0;  // solids: 0 enamel, 128 dentin, 255 caries
  std::uint8_t blood = 0;   // fraction of blood in the colour, times 255
  bool operator==(const FilmTexel&) const = default;
};

/// Temperatures of the working body for View::kTemperature; samples at origin + spacing · (x, y, z).
struct TemperatureGrid {
  dvec3 origin{0};     // m, frame W, position of the first sample
  double spacing = 0;  // m, distance between neighbouring samples
  glm::ivec3 size{0};  // 0: no grid
};

/// Light of room and other surfaces, computed by LightScene; samples at origin + spacing · (x, y, z).
struct LightGrid {
  dvec3 origin{0};     // m, frame W, position of the first sample
  double spacing = 0;  // m, distance between neighbouring samples
  glm::ivec3 size{0};  // 0: no grid
  static constexpr int kFaces = shared::kLightDirections;
  // Light at each sample for a surface that faces +x, -x, +y, -y, +z, -z (index()). xyz: irradiance / π, linear; w:
  // visible fraction of the lamp.
  std::vector<glm::vec4> faces;
  // Light that wet tissue and metal mirror: linear radiance over ±10° around the directions of an octahedral map
  // (image_direction() in light_scene.h); index: image_index().
  static constexpr int kImageSide = shared::kImageSide;
  std::vector<glm::vec3> images;

  std::size_t samples() const { return voxel_count(size); }
  std::size_t index(int face, const glm::ivec3& i) const {
    return static_cast<std::size_t>(face) * samples() + voxel_index(i, size);
  }
  /// Index in `images`. The map of each cell is spread over the axes y and z, because devices limit an axis' size.
  std::size_t image_index(const glm::ivec2& node, const glm::ivec3& i) const {
    const auto side = static_cast<std::size_t>(kImageSide), y = static_cast<std::size_t>(size.y),
               z = static_cast<std::size_t>(size.z);
    const std::size_t row = (static_cast<std::size_t>(i.x) * side + static_cast<std::size_t>(node.x)) * y;
    return ((row + static_cast<std::size_t>(i.y)) * side + static_cast<std::size_t>(node.y)) * z +
           static_cast<std::size_t>(i.z);
  }
};

/// Light that leaves translucent tissue after travelling in it, in cells beside surfaces near the working tooth.
/// Computed by TissueLight; cells at origin + spacing · (x, y, z).
struct TissueLightGrid {
  dvec3 origin{0};     // m, frame W, position of the first cell
  double spacing = 0;  // m, distance between neighbouring cells
  glm::ivec3 size{0};  // 0: no grid
  // Index (x·size.y + y)·size.z + z. xyz: leaving light divided by reflectance, linear. On an opaque body,
  // or a flat layer in even light, this is irradiance / π. w: fraction that came directly from the lamp.
  std::vector<glm::vec4> values;
};

struct ToolState {
  bool visible = false;
  Pose X_WG;           // pose of the servo's proxy, outside the tissue
  double angle = 0;    // rad, rotation of the tool about its z axis
  double spindle = 0;  // rad/s, speed for the motion blur of the flutes
  double opacity = 1;  // fraction of the tool's pixels that are drawn; below 1 while the hand is not tracked
  Pose X_GH;           // pose of the handpiece, if there is one
  bool open = true;    // true: the handpiece is not drawn where it hides the working point
};

/// A ring where the tool would meet the scene along `down`. It shows the depth if the picture is mono.
struct Cursor {
  bool visible = false;
  dvec3 p{0};            // m, frame W, start of the line
  dvec3 down{0, 0, -1};  // unit vector, frame W, direction of the line
  double radius = 1e-3;  // m, radius of the ring
};

/// Lamp and room, in frame W, not mirrored.
struct Lights {
  dvec3 key{-0.35, 0.55, 0.75};  // unit vector towards the lamp
  dvec3 up{0, 1, 0};             // unit vector towards the ceiling
  /// Unit vector towards the window whose light the surfaces reflect; zero: a direction beside the lamp.
  dvec3 window{0, 0, 0};
  double key_strength = 4.0;
  // Spot of the lamp with a soft border at the working tooth, as that of a dental lamp at 0.7 m.
  glm::dvec2 spot{0.15, 0.08};  // m, full width and height; half brightness at the border
  double spot_border = 0.025;   // m, width of the border, from full brightness to zero
  double lamp_width = 0.168;    // m, width of the luminous area, for penumbras
  double lamp_distance = 0.7;   // m, distance of the lamp from the working tooth
  double ambient = 1.0;         // factor by which the room's light is multiplied
};

/// Unit vector towards the window whose light the surfaces reflect.
dvec3 toward_window(const Lights& lights);

/// kBlack: for semi-transparent mirrors; the hand is visible through black pixels. kClear: black with opacity 0, for a
/// headset that shows the room.
enum class Background { kGradient, kBlack, kClear };

struct Frame {
  std::array<Eye, 2> eyes;
  int views = 2;  // number of pictures; 1: mono
  ToolState tool;
  Cursor cursor;
  MouthMirror mirror;  // diameter 0: no mirror
  SuctionTip suction;  // opening 0: no suction tip
  View view = View::kLook;
  glm::dvec4 section{0, 0, 0, 1};  // plane of cuts_section(): unit normal in frame W; w: offset, m
  std::span<const Particle> particles;
  ParticleCloud* cloud = nullptr;  // particles that the renderer moves and draws
  Lights lights;
  Background background = Background::kGradient;
};

/// A rectangle in pixels.
struct PixelBox {
  int x = 0, y = 0, width = 0, height = 0;
  bool operator==(const PixelBox&) const = default;
};

struct FrameStats {
  bool drawn = false;        // false: nothing has changed, so nothing was recorded
  std::uint64_t frames = 0;  // number of frames drawn since the start
  int views = 0;
  double redrawn = 1;  // fraction of the pictures' pixels that was redrawn
  int bricks_drawn = 0, bricks_culled = 0, bricks_facing_away = 0, bricks_covered = 0;
  int bricks_unchanged = 0;  // number of visible bricks that were not redrawn
  std::uint64_t triangles = 0;
  int passes = 0;           // number of recorded render passes
  int commands = 0;         // number of recorded draw calls
  int bricks_uploaded = 0;  // number of bricks uploaded since the last frame
  std::uint64_t bytes_uploaded = 0;
  int pipelines = 0;  // number of pipelines that exist now
  // Bytes uploaded for this frame.
  std::uint64_t film_bytes = 0, temperature_bytes = 0;
  double pixel = 0;  // m, size of a pixel at the point of the working tooth nearest to an eye; 0: no tooth
  // Counts for the mirror's picture, which is drawn if an eye sees the glass. `passes` includes mirror_passes.
  int mirror_passes = 0, mirror_bricks = 0;
  std::uint64_t mirror_triangles = 0;
};

/// Parts of the GPU's work for a frame. kPicture: the end of the render passes, including the averaging of samples.
enum class FramePart : std::uint8_t {
  kShadow,
  kUploads,
  kMirror,
  kHandpiece,
  kTissue,
  kTools,
  kBackground,
  kParticles,
  kPicture
};
inline constexpr std::array<const char*, 9> kFrameParts{"shadow", "uploads",    "mirror",    "handpiece", "tissue",
                                                        "tools",  "background", "particles", "picture"};
/// ms, times of the GPU; 0: the device has no timestamps.
struct GpuTimes {
  std::uint64_t frames = 0;  // number of measured frames so far, including this one
  double frame = 0;
  std::array<double, kFrameParts.size()> parts{};
};

class Renderer {
 public:
  /// `size`: size of one eye's picture, pixels. May throw Error.
  Renderer(gpu::Device& device, glm::ivec2 size, const Quality& quality, const MaterialTable& materials);
  ~Renderer();
  Renderer(Renderer&&) noexcept;

  /// Replaces bricks of a mesh; its other bricks stay.
  void update(MeshId mesh, std::span<const MeshUpdate> bricks);
  void place(MeshId mesh, const Pose& X_WM);
  void remove(MeshId mesh);
  /// Declares that original bricks of the mesh that lie completely at dot(beyond, (p_W, 1)) < 0 are inside another
  /// body. Until these bricks change, kLook and kDifference do not show them. Zero: no plane.
  void cover(MeshId mesh, const glm::dvec4& beyond);
  /// Sets the tool and the handpiece that holds it; a handpiece without parts is not drawn. Throws Error for too
  /// many triangles.
  void set_tool(const ToolMesh& tool, const Handpiece& handpiece = {});
  /// Sets the grid of the film of water and slurry, and clears the film. Size 0: no film, which costs no time.
  void set_film(const FilmGrid& grid);
  /// Updates the boxes `changed` from `texels`, which contains the whole grid, index (x·size.y + y)·size.z + z.
  void update_film(std::span<const FilmTexel> texels, std::span<const CellBox> changed);
  /// Sets the grid of View::kTemperature and clears it.
  void set_temperatures(const TemperatureGrid& grid);
  /// Updates the whole grid, index (x·size.y + y)·size.z + z. x: weight · (temperature − 37 °C), K; y: weight. Only the
  /// weighted mean of the samples around a point is shown, so air has a small weight or none.
  void update_temperatures(std::span<const glm::vec2> values);
  /// Sets the light of room and surfaces, and the light inside tissue. Size 0: light of the room is estimated from the
  /// surface's shape, bodies do not light each other, and `inside` is unused.
  void set_light(const LightGrid& grid, const TissueLightGrid& inside);
  /// Updates the box `changed` from `values`, which contains the whole grid TissueLightGrid::values.
  void update_tissue_light(std::span<const glm::vec4> values, const CellBox& changed);
  void resize(glm::ivec2 size);
  void set_quality(const Quality& quality);
  /// Sets the triangles that a headset's lenses hide. x, y: clip space; z: number of the eye.
  void set_hidden(std::span<const glm::vec3> corners);
  /// Keeps depth for depth(), which a headset's compositor needs.
  void keep_depth(bool keep);

  /// Lets other threads create the pipelines that record() needs for this frame; those of surfaces only if there is a
  /// working tooth. Returns true when record() would wait for none of them. Then continues with those of a partial
  /// redraw and of debris, and, if `lit` is true, those that follow set_light().
  bool prepare(const Frame& frame, bool lit = false);
  /// Records the frame, unless it is equal to the last one. The caller submits the commands. `slot`: frame in flight;
  /// `submitted`: number of this frame; `finished`: number of the newest finished frame.
  FrameStats record(VkCommandBuffer commands, const Frame& frame, int slot, std::uint64_t submitted,
                    std::uint64_t finished);

  /// Times of the latest finished frame. `finished_slot`: frame in flight that the caller knows to have finished.
  GpuTimes gpu_times(std::optional<int> finished_slot = {});
  /// Two layers (mono: one), sRGB bytes; ready after record().
  const gpu::Image& pictures() const;
  /// Parts of an eye's picture redrawn by the last record().
  std::span<const PixelBox> redrawn(int view) const;
  /// Depth picture (D32), in the layout of a copy source after record(). Needs keep_depth(true).
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
