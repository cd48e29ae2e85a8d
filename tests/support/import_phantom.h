// Scans of bodies that are known exactly. They are sampled with partial volume, blur and noise, and written as files.
#pragma once

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <glm/glm.hpp>
#include <random>
#include <string>
#include <vector>

#include "engine/base/units.h"
#include "haptics/dense_tissue.h"
#include "haptics/tissue_mesh.h"

namespace typodont::test {

struct Phantom {
  glm::ivec3 size{64};
  glm::dvec3 spacing{0.15};                       // mm
  std::function<double(const glm::dvec3&)> grey;  // grey value at a position in mm
  double blur = 0;                                // mm, standard deviation of the blur
  double noise = 0;                               // standard deviation of the grey values
  int fine = 8;                                   // subsamples per voxel and axis at tissue boundaries

  /// Returns the samples. x is the fastest index, as in the files.
  std::vector<double> scan(unsigned seed = 1) const {
    std::vector<double> v(static_cast<std::size_t>(size.x) * size.y * static_cast<std::size_t>(size.z));
    const std::vector<double> corners = corner_greys();
    std::size_t i = 0;
    for (int z = 0; z < size.z; ++z) {
      for (int y = 0; y < size.y; ++y) {
        for (int x = 0; x < size.x; ++x, ++i) {
          double sum = 0;
          const double middle = grey(glm::dvec3(x, y, z) * spacing);
          bool pure = true;
          for (int k = 0; k < 8 && pure; ++k)
            pure = corners[corner(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2))] == middle;
          if (pure || fine == 1) {
            v[i] = middle;
            continue;
          }
          for (int k = 0; k < fine * fine * fine; ++k) {
            const glm::dvec3 off((k % fine + 0.5) / fine - 0.5, (k / fine % fine + 0.5) / fine - 0.5,
                                 (k / fine / fine + 0.5) / fine - 0.5);
            sum += grey((glm::dvec3(x, y, z) + off) * spacing);
          }
          v[i] = sum / (fine * fine * fine);
        }
      }
    }
    const int stride[3] = {1, size.x, size.x * size.y};
    for (int a = 0; a < 3 && blur > 0; ++a) {
      const double s = blur / spacing[a];
      const int r = static_cast<int>(4 * s) + 1;
      std::vector<double> weights;
      for (int k = -r; k <= r; ++k) weights.push_back(std::exp(-0.5 * k * k / (s * s)));
      const std::vector<double> from = v;
      for (std::size_t j = 0; j < v.size(); ++j) {
        const int at = static_cast<int>(j) / stride[a] % size[a];
        double sum = 0, norm = 0;
        for (int k = -r; k <= r; ++k) {
          const double w = weights[static_cast<std::size_t>(k + r)];
          const int q = std::clamp(at + k, 0, size[a] - 1);
          sum += w * from[j + static_cast<std::size_t>(static_cast<std::ptrdiff_t>(q - at) * stride[a])];
          norm += w;
        }
        v[j] = sum / norm;
      }
    }
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, 1);
    if (noise > 0) {
      for (double& g : v) g += noise * normal(random);
    }
    return v;
  }

 private:
  std::size_t corner(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * (size.y + 1) + y) * (size.x + 1) + x;
  }
  /// Returns the grey values at the corners of the voxels, each of which up to eight voxels share.
  std::vector<double> corner_greys() const {
    std::vector<double> v(corner(0, 0, size.z + 1));
    for (int z = 0; z <= size.z; ++z) {
      for (int y = 0; y <= size.y; ++y) {
        for (int x = 0; x <= size.x; ++x) v[corner(x, y, z)] = grey((glm::dvec3(x, y, z) - 0.5) * spacing);
      }
    }
    return v;
  }
};

/// Returns a path that contains the process number, so that tests can run in parallel.
inline std::filesystem::path scratch(const std::string& name) {
  static const auto folder = [] {
    const auto f = std::filesystem::temp_directory_path() / fmt::format("typodont_import_{}", getpid());
    std::filesystem::create_directories(f);
    return f;
  }();
  return folder / name;
}

inline void write(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream out(file, std::ios::binary);
  out << bytes;
}

template <class T>
std::string bytes_as(const std::vector<double>& greys, bool big_endian = false) {
  std::string bytes;
  bytes.reserve(greys.size() * sizeof(T));
  for (const double g : greys) {
    T value;
    if constexpr (std::is_integral_v<T>) {
      value = static_cast<T>(std::lround(std::max(g, 0.0)));
    } else {
      value = static_cast<T>(g);
    }
    char b[sizeof(T)];
    std::memcpy(b, &value, sizeof(T));
    if (big_endian) std::reverse(b, b + sizeof(T));
    bytes.append(b, sizeof(T));
  }
  return bytes;
}

inline std::string nrrd_header(const Phantom& p, const std::string& type, const std::string& more) {
  return fmt::format("NRRD0004\ntype: {}\ndimension: 3\nsizes: {} {} {}\nspacings: {} {} {}\n{}\n", type, p.size.x,
                     p.size.y, p.size.z, p.spacing.x, p.spacing.y, p.spacing.z, more);
}

/// Writes an NRRD file with attached data.
inline std::filesystem::path write_nrrd(const std::string& name, const Phantom& p, const std::string& data,
                                        const std::string& type = "unsigned short",
                                        const std::string& more = "endian: little\nencoding: raw\n") {
  write(scratch(name), nrrd_header(p, type, more) + data);
  return scratch(name);
}

/// Writes triangles as a binary STL, in millimetres.
inline std::filesystem::path write_stl(const std::string& name, const haptics::TissueMesh& mesh) {
  std::string bytes(80, ' ');
  const auto add = [&](const auto& value) { bytes.append(reinterpret_cast<const char*>(&value), sizeof value); };
  add(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const glm::uvec3& t : mesh.triangles) {
    add(glm::vec3(0));
    for (int k = 0; k < 3; ++k) add(glm::vec3(mesh.vertices[t[k]] / kMillimetre));
    add(std::uint16_t{0});
  }
  write(scratch(name), bytes);
  return scratch(name);
}

/// Returns the distance field (m) at a position (m), with trilinear interpolation.
inline double distance_at(const haptics::DenseTissue& t, const dvec3& p) {
  const dvec3 q = t.frame.to_voxels(p);
  const glm::ivec3 lo = glm::clamp(glm::ivec3(glm::floor(q)), glm::ivec3(0), t.size - 2);
  const dvec3 s = q - dvec3(lo);
  double sum = 0;
  for (int c = 0; c < 8; ++c) {
    const glm::ivec3 o(c & 1, c >> 1 & 1, c >> 2);
    const dvec3 w = glm::mix(1.0 - s, s, dvec3(o));
    sum += w.x * w.y * w.z * static_cast<double>(t.distance[t.at(lo.x + o.x, lo.y + o.y, lo.z + o.z)]);
  }
  return sum;
}

}  // namespace typodont::test
