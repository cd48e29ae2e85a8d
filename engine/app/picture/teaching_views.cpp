#include "engine/app/picture/teaching_views.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/app/picture/field_mesh.h"
#include "engine/app/picture/tooth_field.h"

namespace typodont {

namespace {

constexpr int kFaceTile = 48;              // cells a side of a piece of a section's face: what indices and culling like
constexpr double kBesidePlane = 2e-6;      // m: the face lies so far within what is kept, so that clipping keeps it
constexpr double kDifferenceReach = 3e-3;  // m

/// The tissues of a corner that may be drawn: what is not air.
std::size_t commonest(const std::array<double, kTissueCount>& shares, std::size_t except = 0) {
  std::size_t best = 0;
  for (std::size_t t = 1; t < shares.size(); ++t)
    if (t != except && shares[t] > (best ? shares[best] : 0.0)) best = t;
  return best;
}

}  // namespace

std::vector<render::MeshUpdate> section_face(const haptics::TissueVolume& volume, const dvec3& normal, double offset) {
  const ToothField field(volume);
  const dvec3 n = glm::normalize(normal), origin = volume.frame().origin;
  const dvec3 u = glm::normalize(std::abs(n.z) < 0.9 ? glm::cross(dvec3(0, 0, 1), n) : glm::cross(dvec3(0, 1, 0), n));
  const dvec3 v = glm::cross(n, u);  // u × v = n
  // The part of the plane within the volume's bounds.
  glm::dvec2 lo(1e9), hi(-1e9);
  for (int corner = 0; corner < 8; ++corner) {
    const dvec3 p(corner & 1 ? field.high().x : field.low().x, corner & 2 ? field.high().y : field.low().y,
                  corner & 4 ? field.high().z : field.low().z);
    const glm::dvec2 at(glm::dot(p, u), glm::dot(p, v));
    lo = glm::min(lo, at);
    hi = glm::max(hi, at);
  }
  const double h = field.voxel();
  const glm::ivec2 cells = glm::ivec2(glm::ceil((hi - lo) / h));
  struct Sample {
    dvec3 p;
    double d;
    std::array<double, kTissueCount> shares;
  };
  const auto sample = [&](const glm::dvec2& at) {
    Sample s{n * (offset + kBesidePlane) + u * at.x + v * at.y, 0, {}};
    s.d = field.distance(s.p);
    if (s.d < h) s.shares = field.shares(s.p);
    return s;
  };

  std::vector<render::MeshUpdate> updates;
  for (int tile_x = 0; tile_x < cells.x; tile_x += kFaceTile)
    for (int tile_y = 0; tile_y < cells.y; tile_y += kFaceTile) {
      render::MeshUpdate update;
      update.brick = (static_cast<std::uint64_t>(tile_x) << 32) | static_cast<std::uint64_t>(tile_y);
      const int nx = std::min(kFaceTile, cells.x - tile_x), ny = std::min(kFaceTile, cells.y - tile_y);
      std::vector<Sample> grid;
      for (int i = 0; i <= nx; ++i)
        for (int j = 0; j <= ny; ++j) grid.push_back(sample(lo + h * glm::dvec2(tile_x + i, tile_y + j)));
      for (int i = 0; i < nx; ++i)
        for (int j = 0; j < ny; ++j) {
          const auto at = [&](int a, int b) -> const Sample& {
            return grid[static_cast<std::size_t>(i + a) * (ny + 1) + static_cast<std::size_t>(j + b)];
          };
          const std::array<const Sample*, 4> corners{&at(0, 0), &at(1, 0), &at(1, 1), &at(0, 1)};
          // The cell's part inside the tissue: its corners there and where the outline crosses its edges, in order.
          std::array<Sample, 8> part;
          std::size_t count = 0;
          std::array<double, kTissueCount> sum{};
          for (std::size_t k = 0; k < 4; ++k) {
            const Sample &a = *corners[k], &b = *corners[(k + 1) % 4];
            if (a.d < 0) part[count++] = a;
            if ((a.d < 0) != (b.d < 0))
              part[count++] = sample([&] {
                const dvec3 p = glm::mix(a.p, b.p, a.d / (a.d - b.d));
                return glm::dvec2(glm::dot(p, u), glm::dot(p, v));
              }());
          }
          if (count < 3) continue;
          for (std::size_t k = 0; k < count; ++k)
            for (std::size_t t = 1; t < sum.size(); ++t) sum[t] += part[k].shares[t];
          const std::size_t first = commonest(sum), second = commonest(sum, first);
          if (!first) continue;
          const auto base = static_cast<std::uint32_t>(update.vertices.size());
          for (std::size_t k = 0; k < count; ++k) {
            render::Vertex vertex;
            vertex.p = glm::vec3(part[k].p - origin);
            vertex.n = glm::vec3(-n);
            vertex.tissue = {static_cast<Tissue>(first), static_cast<Tissue>(second ? second : first)};
            const double a = part[k].shares[first], b = second ? part[k].shares[second] : 0;
            vertex.second = static_cast<float>(a + b > 0 ? b / (a + b) : 0);
            update.vertices.push_back(vertex);
          }
          // Seen against the normal, so the other way round.
          for (std::uint32_t k = 1; k + 1 < count; ++k)
            update.indices.insert(update.indices.end(), {base, base + k + 1, base + k});
        }
      if (!update.indices.empty()) updates.push_back(std::move(update));
    }
  return updates;
}

std::vector<render::MeshUpdate> tissue_inside(const haptics::TissueVolume& volume, Tissue tissue) {
  const ToothField field(volume);
  const double h = field.voxel();
  // The dentin's outer surface is wanted, not that of the cavities in it: pulp and decay count as filled.
  const auto counts = [&](Tissue found) {
    return found == tissue || (tissue == Tissue::kDentin && (found == Tissue::kPulp || found == Tissue::kCaries));
  };
  const auto here = [&](const dvec3& p) { return counts(field.tissue(p)) && field.distance(p) < 0; };
  // Whole voxels from the volume's origin, so that samples lie on samples.
  const dvec3 origin = volume.frame().origin;
  const dvec3 lo = origin + h * glm::floor((field.low() - origin) / h);
  glm::dvec3 first(1e9), last(-1e9);
  const glm::ivec3 size(glm::ceil((field.high() - lo) / h));
  glm::ivec3 i;
  for (i.x = 0; i.x <= size.x; ++i.x)
    for (i.y = 0; i.y <= size.y; ++i.y)
      for (i.z = 0; i.z <= size.z; ++i.z)
        if (const dvec3 p = lo + h * dvec3(i); here(p)) {
          first = glm::min(first, p);
          last = glm::max(last, p);
        }
  if (first.x > last.x) return {};
  first -= 3 * h;
  last += 3 * h;
  std::vector<render::MeshUpdate> updates = mesh_of_field(
      first, last, h, 0.15f,
      [&](const dvec3& p) {
        double share = 0;  // binomial weights over 27 samples
        for (int x = -1; x <= 1; ++x)
          for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z)
              if (here(p + h * dvec3(x, y, z))) share += (x ? 1 : 2) * (y ? 1 : 2) * (z ? 1 : 2) / 64.0;
        return (0.5 - share) * 2 * h;
      },
      [&](const dvec3&) { return tissue; });
  for (render::MeshUpdate& update : updates)
    for (render::Vertex& vertex : update.vertices) vertex.p += glm::vec3(first - origin);
  return updates;
}

std::vector<render::MeshUpdate> tissues_left(const haptics::TissueVolume& volume, std::uint32_t hidden) {
  const ToothField field(volume);
  const double h = field.voxel();
  const dvec3 origin = volume.frame().origin;
  const dvec3 first = origin + h * glm::floor((field.low() - origin) / h);
  const auto left = [&](Tissue t) { return t != Tissue::kAir && !(hidden >> static_cast<unsigned>(t) & 1u); };
  std::vector<render::MeshUpdate> updates = mesh_of_field(
      first, field.high(), h, 0.15f,
      [&](const dvec3& p) {
        const double whole = field.distance(p);
        if (whole > h) return whole;
        double share = 0;  // of what is left, binomial weights over 27 samples
        for (int x = -1; x <= 1; ++x)
          for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z)
              if (left(field.tissue(p + h * dvec3(x, y, z)))) share += (x ? 1 : 2) * (y ? 1 : 2) * (z ? 1 : 2) / 64.0;
        // Outside the tissue labels thin out: there the surface is the tissue's own.
        return std::max(whole, share > 0.999 ? -h : (0.5 - share) * 2 * h);
      },
      [&](const dvec3& p) {
        const Tissue here = field.tissue(p);
        if (left(here)) return here;
        std::array<int, kTissueCount> around{};
        for (int x = -1; x <= 1; ++x)
          for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z)
              if (const Tissue t = field.tissue(p + h * dvec3(x, y, z)); left(t)) ++around[static_cast<std::size_t>(t)];
        const auto most = std::max_element(around.begin(), around.end());
        return *most ? static_cast<Tissue>(most - around.begin()) : Tissue::kAir;
      });
  for (render::MeshUpdate& update : updates)
    for (render::Vertex& vertex : update.vertices) vertex.p += glm::vec3(first - origin);
  return updates;
}

void mark_difference(const haptics::TissueVolume& ideal, const dvec3& origin,
                     std::vector<render::MeshUpdate>& updates) {
  mark_difference(ToothField(ideal, kDifferenceReach), origin, updates);
}

void mark_difference(const ToothField& ideal, const dvec3& origin, std::vector<render::MeshUpdate>& updates) {
  for (render::MeshUpdate& update : updates)
    for (render::Vertex& vertex : update.vertices)
      vertex.difference = static_cast<float>(ideal.distance(origin + dvec3(vertex.p)));
}

}  // namespace typodont
