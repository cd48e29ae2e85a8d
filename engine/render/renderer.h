// Draws the workbench for both eyes: tissue bricks (blocks of triangles), tool, particles, static surroundings. The
// render thread owns the renderer. The renderer draws two eyes in one pass (multiview) into a picture with two layers;
// a display composes and shows this picture (engine/display). Objects that a frame does not contain have no pipeline
// and load no shader. A frame equal to the previous frame is not drawn again. FrameStats counts the work. README.md of
// this folder has an overview and defines the terms.
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

/// A vertex of a surface. The three corners of a triangle store the same two tissues. A sharp boundary between the
/// tissues is drawn where the interpolated `second` equals one half.
struct Vertex {
  glm::vec3 p{0};        // m, position relative to the mesh's origin
  glm::vec3 n{0, 0, 1};  // unit normal, pointing out of the tissue
  std::array<Tissue, 2> tissue{Tissue::kEnamel, Tissue::kEnamel};
  float second = 0;             // 0..1, fraction of the second tissue, tissue[1]
  Tissue under = Tissue::kAir;  // the tissue below the surface tissue
  float shows = 0;              // 0..1, fraction of the lower tissue's colour that is visible through the surface
  float depth = 0;              // m, depth of the lower tissue below the surface
  float cut = 0;                // 0..1, fraction of the surface around the vertex that was made by cutting
  float thin = 0;               // 0..1, thinness of the tissue below the surface; 0: thicker than kTranslucentThickness
  float difference = 0;         // m, tissue still to remove (> 0) or excess removal (< 0), for View::kDifference
};

/// m; tissue that is thicker than this lets no visible light through
inline constexpr double kTranslucentThickness = 1.6e-3;

/// The present content of one brick (a block of triangles) of a mesh. An empty content removes the brick.
struct MeshUpdate {
  std::uint64_t brick = 0;  // number of the brick; any number that is unique in the mesh
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> indices;  // triangles, counter-clockwise seen from outside
  bool two_sided = false;              // true for an open surface: its back is drawn too, in dull blue-grey
};

/// Number of a body made of bricks (blocks of triangles): the working tooth, gingiva, a neighbour.
using MeshId = std::uint32_t;
inline constexpr MeshId kWorkingTooth = 0;
// Bodies that only one view shows.
inline constexpr MeshId kSectionFace = 1000, kSectionFaceAround = 1001;                  // shown only in View::kSection
inline constexpr MeshId kInsidePulp = 1002, kInsideCaries = 1003, kInsideDentin = 1004;  // shown only in View::kXray

/// How the scene is shown: realistically, or in a view for teaching.
enum class View {
  kLook,
  kSection,  // tissue is drawn only where section · (p, 1) > 0, with the cut faces of the bodies
  kXray,     // the working tooth as glass, with the tissues inside it; other bodies are not drawn
  // the working tooth compared with an ideal, the target shape (Vertex::difference): blue tissue must still be removed;
  // where the surface is red, too much was removed
  kDifference,
};

struct Eye {
  glm::dmat4 view{1.0};        // maps positions (m) from frame W to the eye's frame
  glm::dmat4 projection{1.0};  // maps the eye's frame to Vulkan's clip space
  dvec3 position{0, 0, 0};     // m, frame W, position of the eye
  bool flip = false;           // true if the eye sees the scene in a mirror
};

struct Particle {
  glm::vec3 p{0};        // m, frame W, position of the particle
  float radius = 2e-5f;  // m, radius of the particle
  glm::vec3 color{1};    // sRGB, colour of the particle
  float opacity = 1;     // opacity of the particle: 1 for a chip, less for mist
  glm::vec3 streak{0};   // m, frame W: path of a droplet during the exposure; it ends at p
};

/// A box of samples of a grid: from lo to hi, both included. The default is an empty box.
struct CellBox {
  glm::ivec3 lo{std::numeric_limits<int>::max()}, hi{std::numeric_limits<int>::min()};
  bool empty() const { return lo.x > hi.x || lo.y > hi.y || lo.z > hi.z; }
  void take(const CellBox& other) { lo = glm::min(lo, other.lo), hi = glm::max(hi, other.hi); }
  bool meets(const CellBox& other) const { return !CellBox{glm::max(lo, other.lo), glm::min(hi, other.hi)}.empty(); }
};

/// The grid of the film of water and slurry on the working tooth; its samples are at origin + spacing · (x, y, z).
struct FilmGrid {
  dvec3 origin{0};     // m, frame W, position of the first sample
  double spacing = 0;  // m, distance between neighbouring samples
  glm::ivec3 size{0};  // number of samples along x, y and z; 0: no film
};
/// The film at a sample, as shaders/film.glsl reads it. All members are zero for a dry and clean surface.
struct FilmTexel {
  std::uint8_t water = 0;   // height of the water: 255 · (1 − exp(−height / 80 µm))
  std::uint8_t cover = 0;   // opacity of the solids, times 255
  std::uint8_t colour = 0;  // colour of the solids: 0 enamel, 128 dentin, 255 caries
  std::uint8_t blood = 0;   // fraction of blood in the colour, times 255
  bool operator==(const FilmTexel&) const = default;
};

/// Light from the room and from other surfaces, on a grid of samples at origin + spacing · (x, y, z). LightScene
/// computes this grid.
struct LightGrid {
  dvec3 origin{0};     // m, frame W, position of the first sample
  double spacing = 0;  // m, distance between neighbouring samples
  glm::ivec3 size{0};  // number of samples along x, y and z; 0: no grid
  static constexpr int kFaces = shared::kLightDirections;
  // Light for a surface that faces +x, -x, +y, -y, +z or -z (see index()). xyz: irradiance divided by π, linear; w:
  // fraction of the lamp that is visible from the sample.
  std::vector<glm::vec4> faces;
  // Mirrored light, for wet tissue and metal: the linear radiance from each direction, averaged over a lobe of about
  // ±10°. The directions are the nodes of an octahedral map (image_direction() in light_scene.h); see image_index().
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
  /// Returns the index in `images` of a sample's node. The nodes of a 3-D image are along its y and z axes, because
  /// devices limit the length of an axis.
  std::size_t image_index(const glm::ivec2& node, const glm::ivec3& i) const {
    const auto side = static_cast<std::size_t>(kImageSide), y = static_cast<std::size_t>(size.y),
               z = static_cast<std::size_t>(size.z);
    const std::size_t row = (static_cast<std::size_t>(i.x) * side + static_cast<std::size_t>(node.x)) * y;
    return ((row + static_cast<std::size_t>(i.y)) * side + static_cast<std::size_t>(node.y)) * z +
           static_cast<std::size_t>(i.z);
  }
};

/// Light that leaves translucent tissue after it has travelled in it, in a grid of cells at origin + spacing · (x, y,
/// z) around the working tooth. Only the cells beside surfaces have light. TissueLight computes this grid.
struct TissueLightGrid {
  dvec3 origin{0};     // m, frame W, position of the first cell
  double spacing = 0;  // m, distance between neighbouring cells
  glm::ivec3 size{0};  // number of cells along x, y and z; 0: no grid
  // With the index (x·size.y + y)·size.z + z. xyz: light that leaves the surface, divided by the tissue's reflectance,
  // linear: in a flat layer or on an opaque body, this is the irradiance divided by π, if the light is the same
  // everywhere. w: fraction of it that came directly from the lamp.
  std::vector<glm::vec4> values;
};

struct ToolState {
  bool visible = false;
  Pose X_WG;           // pose of the drawn tool (the servo's proxy, which stays outside the tissue)
  double angle = 0;    // rad, angle of the spindle about the tool's z
  double spindle = 0;  // rad/s, speed of the spindle, which determines the motion blur of the flutes
  double opacity = 1;  // fraction of the tool's pixels that is drawn; below 1 while the hand is out of sight
  Pose X_GH;           // pose of the handpiece relative to the tool; used only if the renderer has a handpiece
  bool open = true;    // true: the handpiece is not drawn where it hides the working point from an eye
};

/// Marks the point where the tool would meet the scene if it moved straight along `down`: a ring is drawn at that
/// point. The ring helps to judge depth in a mono picture.
struct Cursor {
  bool visible = false;
  dvec3 p{0};            // m, frame W: point from which the tool would move
  dvec3 down{0, 0, -1};  // unit vector, frame W: direction in which the tool would move
  double radius = 1e-3;  // m, radius of the ring
};

/// The lights of the scene. Directions are given in frame W and are not mirrored.
struct Lights {
  dvec3 key{-0.35, 0.55, 0.75};  // unit vector towards the lamp
  dvec3 up{0, 1, 0};             // unit vector towards the ceiling
  /// unit vector towards the window that glossy surfaces reflect; zero: the window is beside the lamp
  dvec3 window{0, 0, 0};
  double key_strength = 4.0;
  // The lamp: a spot with a soft border at the working tooth, like the spot of a dental lamp at 0.7 m.
  glm::dvec2 spot{0.15, 0.08};  // m, width and height of the spot; at its sides, the light has half its brightness
  double spot_border = 0.025;   // m, width of the border in which the light falls from its full brightness to zero
  double lamp_width = 0.168;    // m, width of the lamp's luminous area, which determines the penumbra of shadows
  double lamp_distance = 0.7;   // m, distance of the lamp from the working tooth
  double ambient = 1.0;         // factor by which the room's light is multiplied
};

/// Returns the unit vector towards the window.
dvec3 toward_window(const Lights& lights);

/// A half mirror needs kBlack, because the user sees the hand through black pixels. kClear is black with opacity 0: a
/// headset shows the room in these pixels.
enum class Background { kGradient, kBlack, kClear };

struct Frame {
  std::array<Eye, 2> eyes;
  int views = 2;  // number of pictures; 1: mono
  ToolState tool;
  Cursor cursor;
  MouthMirror mirror;  // the mouth mirror in the other hand; diameter 0: no mirror
  SuctionTip suction;  // the suction tip; if its opening is 0, there is no tip
  View view = View::kLook;
  glm::dvec4 section{0, 0, 0, 1};  // section plane for View::kSection: xyz: unit normal, frame W; w: offset, m
  std::span<const Particle> particles;
  ParticleCloud* cloud = nullptr;  // particles on the GPU; the renderer moves and draws them
  Lights lights;
  Background background = Background::kGradient;
};

/// A rectangle of a picture; position and size in pixels.
struct PixelBox {
  int x = 0, y = 0, width = 0, height = 0;
  bool operator==(const PixelBox&) const = default;
};

struct FrameStats {
  bool drawn = false;        // true if the frame was drawn; false: nothing has changed and no commands were recorded
  std::uint64_t frames = 0;  // number of frames drawn since the start
  int views = 0;
  double redrawn = 1;  // fraction of the pictures that was redrawn
  int bricks_drawn = 0, bricks_culled = 0, bricks_facing_away = 0, bricks_covered = 0;
  int bricks_unchanged = 0;  // number of bricks that are in view, but only in parts that are not redrawn
  std::uint64_t triangles = 0;
  int passes = 0;           // number of recorded render passes
  int commands = 0;         // number of recorded draw calls
  int bricks_uploaded = 0;  // number of bricks (blocks of triangles) uploaded since the last frame
  std::uint64_t bytes_uploaded = 0;
  int pipelines = 0;             // number of pipelines that exist now
  std::uint64_t film_bytes = 0;  // number of bytes that were uploaded for the film on the surfaces
  double pixel = 0;  // m, size of a drawn pixel on the working tooth at its point nearest to an eye; 0: no tooth
  // Numbers of passes and bricks for the picture in the mouth mirror, which is drawn only if an eye sees the glass.
  // `passes` includes mirror_passes.
  int mirror_passes = 0, mirror_bricks = 0;
  std::uint64_t mirror_triangles = 0;
  double gpu_ms = 0;  // ms, GPU time of the last finished frame; 0 if the device has no timestamps
};

class Renderer {
 public:
  /// Creates the renderer. `size` is the size of one eye's picture. The constructor may throw Error.
  Renderer(gpu::Device& device, glm::ivec2 size, const Quality& quality, const MaterialTable& materials);
  ~Renderer();
  Renderer(Renderer&&) noexcept;

  /// Uploads the given bricks (blocks of triangles); all other bricks stay unchanged.
  void update(MeshId mesh, std::span<const MeshUpdate> bricks);
  void place(MeshId mesh, const Pose& X_WM);
  void remove(MeshId mesh);
  /// Some bricks (blocks of triangles) are inside another body from the start. This function sets a plane for the mesh.
  /// Bricks that exist since the start and lie completely where dot(beyond, (p_W, 1)) < 0 are not drawn in View::kLook
  /// and kDifference until they change. Zero: no plane.
  void cover(MeshId mesh, const glm::dvec4& beyond);
  /// Sets the tool, and the handpiece in which it is clamped. A handpiece without parts is not drawn. Throws Error if
  /// the handpiece has too many triangles.
  void set_tool(const ToolMesh& tool, const Handpiece& handpiece = {});
  /// Sets the grid of the film on the surfaces, and clears the film. If the size is 0, there is no film, and drawing
  /// takes no time for it.
  void set_film(const FilmGrid& grid);
  /// Copies the `changed` boxes of the film from `texels`, the whole grid with the index (x·size.y + y)·size.z + z.
  void update_film(std::span<const FilmTexel> texels, std::span<const CellBox> changed);
  /// Sets the light that tissue receives from the room and from other surfaces, and the light that has travelled inside
  /// the tissue near the working tooth. If the size of `grid` is 0, the room's light is estimated from the shape of the
  /// surface near each point, bodies do not reflect light to each other, and `inside` is not used.
  void set_light(const LightGrid& grid, const TissueLightGrid& inside);
  /// Copies the `changed` box of the light inside tissue from `values`, the whole grid (TissueLightGrid::values).
  void update_tissue_light(std::span<const glm::vec4> values, const CellBox& changed);
  void resize(glm::ivec2 size);
  void set_quality(const Quality& quality);
  /// Sets triangles of each eye's picture that the user cannot see (behind a headset's lenses); nothing is drawn there.
  /// x, y: clip space of the picture; z: index of the eye.
  void set_hidden(std::span<const glm::vec3> corners);
  /// If `keep` is true, depth() provides each frame's depth, which a headset's compositor needs.
  void keep_depth(bool keep);

  /// Records the commands of the frame, unless it equals the last frame; the caller submits the commands. `slot` is the
  /// index of the frame in flight.
  FrameStats record(VkCommandBuffer commands, const Frame& frame, int slot, std::uint64_t submitted,
                    std::uint64_t finished);

  /// Returns the eyes' pictures: two layers (one layer if mono), sRGB bytes, ready for sampling or copying after
  /// record().
  const gpu::Image& pictures() const;
  /// Returns the parts of an eye's picture that the last record() redrew.
  std::span<const PixelBox> redrawn(int view) const;
  /// Depth picture of an eye, in format D32. After record(), its Vulkan image layout is that of a copy source. Needs
  /// keep_depth(true).
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
