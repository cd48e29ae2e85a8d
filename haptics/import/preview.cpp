// Writes pictures with which a user checks an import.
#include <fmt/format.h>
#include <png.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <set>

#include "engine/base/error.h"
#include "engine/base/folder.h"
#include "engine/base/json.h"
#include "engine/base/units.h"
#include "haptics/import/import.h"

namespace typodont::haptics {

namespace {

struct Picture {
  int width = 0, height = 0;
  std::vector<std::uint8_t> rgb;
  Picture(int w, int h) : width(w), height(h), rgb(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * 3, 24) {}
  void set(int x, int y, const dvec3& c) {
    for (int k = 0; k < 3; ++k) {
      rgb[(static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x)) * 3 + static_cast<std::size_t>(k)] =
          static_cast<std::uint8_t>(std::clamp(c[k], 0.0, 1.0) * 255 + 0.5);
    }
  }
};

void write_png(const std::filesystem::path& file, const Picture& picture) {
  png_image image;
  std::memset(&image, 0, sizeof image);
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(picture.width);
  image.height = static_cast<png_uint_32>(picture.height);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = 0;
  std::string bytes;
  bool good = png_image_write_get_memory_size(image, size, 0, picture.rgb.data(), 0, nullptr) != 0;
  if (good) {
    bytes.resize(size);
    good = png_image_write_to_memory(&image, bytes.data(), &size, 0, picture.rgb.data(), 0, nullptr) != 0;
  }
  if (!good) throw RunFailure(fmt::format("{}: PNG: {}", file.string(), image.message));
  bytes.resize(size);
  write_file_atomically(file, bytes, FileKind::kPicture);
}

dvec3 color_of(Tissue tissue) {
  static const std::map<Tissue, dvec3> kColors{
      {Tissue::kEnamel, {0.55, 0.80, 1.00}},         {Tissue::kDentin, {0.95, 0.80, 0.35}},
      {Tissue::kPulp, {0.90, 0.20, 0.25}},           {Tissue::kCorticalBone, {0.92, 0.90, 0.80}},
      {Tissue::kCancellousBone, {0.85, 0.50, 0.45}}, {Tissue::kGingiva, {0.95, 0.55, 0.60}},
      {Tissue::kAmalgam, {0.45, 0.45, 0.50}}};
  const auto found = kColors.find(tissue);
  return found == kColors.end() ? dvec3(0.7) : found->second;
}

// Cells of edge `cell` (m) that contain a repair, and their neighbours.
class Repaired {
 public:
  Repaired(const std::vector<dvec3>& points, double cell) : cell_(cell) {
    for (const dvec3& p : points) {
      const glm::ivec3 c(glm::floor(p / cell_));
      for (int k = 0; k < 27; ++k) cells_.insert(key(c + glm::ivec3(k % 3, k / 3 % 3, k / 9) - 1));
    }
  }
  bool near(const dvec3& p) const { return cells_.contains(key(glm::ivec3(glm::floor(p / cell_)))); }

 private:
  static std::array<int, 3> key(const glm::ivec3& c) { return {c.x, c.y, c.z}; }
  double cell_;
  std::set<std::array<int, 3>> cells_;
};

// Draws the surface from four sides and both ends, with light from above and repairs in magenta.
Picture shaded(const Imported& imported) {
  const DenseTissue& t = imported.tissue;
  const dvec3 lo = t.frame.to_voxels(imported.report.lo), hi = t.frame.to_voxels(imported.report.hi);
  const dvec3 middle = 0.5 * (lo + hi);
  const double reach = 0.5 * glm::length(hi - lo);
  constexpr int kTile = 420;
  // Edge of the marks of repairs, m: three pixels.
  const double cell = std::max(t.frame.voxel, 2.1 * reach / kTile * t.frame.voxel);
  const Repaired repaired(imported.report.repaired, cell);
  // Distance in voxels, trilinear.
  const auto distance = [&](const dvec3& p) {
    const dvec3 q = glm::clamp(p, dvec3(0.0), dvec3(t.size) - 1.001);
    const glm::ivec3 i(q);
    const dvec3 f = q - dvec3(i);
    double sum = 0;
    for (int k = 0; k < 8; ++k) {
      const glm::ivec3 c(k & 1, k >> 1 & 1, k >> 2);
      const double w = (c.x ? f.x : 1 - f.x) * (c.y ? f.y : 1 - f.y) * (c.z ? f.z : 1 - f.z);
      sum += w * static_cast<double>(t.distance[t.at(i.x + c.x, i.y + c.y, i.z + c.z)]);
    }
    return sum / t.frame.voxel;
  };
  const std::array<std::pair<dvec3, dvec3>, 6> views = {{{{0, -1, 0}, {0, 0, 1}},
                                                         {{1, 0, 0}, {0, 0, 1}},
                                                         {{0, 1, 0}, {0, 0, 1}},
                                                         {{-1, 0, 0}, {0, 0, 1}},
                                                         {{0, 0, 1}, {0, 1, 0}},
                                                         {{0, 0, -1}, {0, 1, 0}}}};
  Picture picture(3 * kTile, 2 * kTile);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const auto& [back, up] = views[v];
    const dvec3 right = glm::cross(up, back);
    const dvec3 light = glm::normalize(back + 0.8 * up - 0.5 * right);
    for (int y = 0; y < kTile; ++y) {
      for (int x = 0; x < kTile; ++x) {
        const double scale = 1.05 * reach;
        const dvec3 from = middle + ((x + 0.5) / kTile * 2 - 1) * scale * right -
                           ((y + 0.5) / kTile * 2 - 1) * scale * up + reach * back;
        dvec3 color(0.1);
        for (double along = 0; along < 2 * reach;) {
          const dvec3 p = from - along * back;
          const double d = distance(p);
          if (d < 0.01) {
            dvec3 n;
            for (int a = 0; a < 3; ++a) {
              dvec3 e(0);
              e[a] = 0.5;
              n[a] = distance(p + e) - distance(p - e);
            }
            const glm::ivec3 i = glm::clamp(glm::ivec3(glm::round(p)), glm::ivec3(0), t.size - 1);
            const double lit = std::max(0.0, glm::dot(glm::normalize(n + 1e-9), light));
            const dvec3 own = repaired.near(t.frame.to_world(p))
                                  ? dvec3(1, 0, 1)
                                  : glm::mix(dvec3(1), color_of(t.tissue[t.at(i.x, i.y, i.z)]), 0.5);
            color = own * (0.15 + 0.85 * lit);
            break;
          }
          along += std::max(0.8 * d, 0.02);
        }
        picture.set(static_cast<int>(v % 3) * kTile + x, static_cast<int>(v / 3) * kTile + y, color);
      }
    }
  }
  return picture;
}

}  // namespace

std::vector<std::filesystem::path> write_preview(const Imported& imported, const std::filesystem::path& folder) {
  make_folder(folder);
  const DenseTissue& t = imported.tissue;
  const ImportReport& report = imported.report;
  const bool has_grey = !imported.grey.empty();
  const double black = report.outside_grey - 0.5 * (report.soft_grey - report.outside_grey);
  const double white = report.dense_level.value_or(report.soft_grey) * 1.1 - 0.1 * report.outside_grey;
  std::vector<std::filesystem::path> files;

  // Draws the slice across axis `w` at `level`, with `u` to the right and `v` up; grey values left, tissues right.
  const auto slice = [&](const std::string& name, int w, int u, int v, double level) {
    const int pixels = std::clamp(720 / std::max(t.size[u], t.size[v]), 1, 12);
    const int width = (t.size[u] - 1) * pixels, height = (t.size[v] - 1) * pixels;
    Picture picture(has_grey ? 2 * width + 8 : width, height);
    const int k = std::clamp(static_cast<int>(std::lround(level)), 0, t.size[w] - 1);
    const auto at = [&](int a, int b) {
      glm::ivec3 p;
      p[w] = k, p[u] = std::clamp(a, 0, t.size[u] - 1), p[v] = std::clamp(b, 0, t.size[v] - 1);
      return t.at(p.x, p.y, p.z);
    };
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const double a = (x + 0.5) / pixels, b = (height - y - 0.5) / pixels;
        const int ia = static_cast<int>(a), ib = static_cast<int>(b);
        const double fa = a - ia, fb = b - ib;
        const auto mix = [&](const std::vector<float>& g) {
          return (1 - fa) *
                     ((1 - fb) * static_cast<double>(g[at(ia, ib)]) + fb * static_cast<double>(g[at(ia, ib + 1)])) +
                 fa * ((1 - fb) * static_cast<double>(g[at(ia + 1, ib)]) +
                       fb * static_cast<double>(g[at(ia + 1, ib + 1)]));
        };
        const double d = mix(t.distance) / t.frame.voxel * pixels;  // distance from the surface in pixels
        const double grey = has_grey ? std::clamp((mix(imported.grey) - black) / (white - black), 0.0, 1.0) : 0.25;
        dvec3 color(0.6 * grey);
        if (d <= 0)
          color = color_of(t.tissue[at(static_cast<int>(std::lround(a)), static_cast<int>(std::lround(b)))]) *
                  (0.45 + 0.55 * grey);
        if (std::abs(d) < 0.8) color = {0.1, 0.95, 0.3};
        picture.set(x + (has_grey ? width + 8 : 0), y, color);
        if (has_grey) picture.set(x, y, dvec3(grey));
      }
    }
    files.push_back(folder / (name + ".png"));
    write_png(files.back(), picture);
  };
  const dvec3 lo = t.frame.to_voxels(report.lo), hi = t.frame.to_voxels(report.hi);
  for (int k = 0; k < 8; ++k) {
    const double level = lo.z + (hi.z - lo.z) * (0.06 + 0.88 * k / 7);
    slice(fmt::format("axial_{}", k + 1), 2, 0, 1, level);
  }
  for (int k = 0; k < 3; ++k) {
    slice(fmt::format("coronal_{}", k + 1), 1, 0, 2, lo.y + (hi.y - lo.y) * (0.3 + 0.2 * k));
    slice(fmt::format("sagittal_{}", k + 1), 0, 1, 2, lo.x + (hi.x - lo.x) * (0.3 + 0.2 * k));
  }
  files.push_back(folder / "surface.png");
  write_png(files.back(), shaded(imported));
  return files;
}

}  // namespace typodont::haptics
