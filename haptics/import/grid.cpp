#include "haptics/import/grid.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace typodont::haptics::importing {

void for_each_slab(int n, const std::function<void(int)>& work) {
  tbb::parallel_for(0, n, work);
}

float sample(const Grid<float>& g, const glm::dvec3& p) {
  const glm::dvec3 q = glm::clamp(p, glm::dvec3(0.0), glm::dvec3(g.size - 1));
  const glm::ivec3 i = glm::min(glm::ivec3(q), glm::max(g.size - 2, glm::ivec3(0)));
  const glm::ivec3 j = glm::min(i + 1, g.size - 1);
  const glm::vec3 t(q - glm::dvec3(i));
  const auto line = [&](int x, int y) { return g(x, y, i.z) + t.z * (g(x, y, j.z) - g(x, y, i.z)); };
  const float a = line(i.x, i.y), b = line(i.x, j.y), c = line(j.x, i.y), d = line(j.x, j.y);
  const float e = a + t.y * (b - a), f = c + t.y * (d - c);
  return e + t.x * (f - e);
}

Grid<float> gaussian(const Grid<float>& g, double sigma) {
  const int r = std::max(1, static_cast<int>(std::ceil(3.5 * sigma)));
  std::vector<float> kernel(static_cast<std::size_t>(r + 1));
  double sum = 0;
  for (int k = -r; k <= r; ++k) sum += std::exp(-0.5 * k * k / (sigma * sigma));
  for (int k = 0; k <= r; ++k) {
    kernel[static_cast<std::size_t>(k)] = static_cast<float>(std::exp(-0.5 * k * k / (sigma * sigma)) / sum);
  }
  // Copies lines of samples first, because the result overwrites its input. Along x and y, `wide` neighbouring lines
  // are processed together.
  Grid<float> out = g;
  constexpr int kWide = 64;
  for (int axis = 0; axis < 3; ++axis) {
    const int n = g.size[axis];
    const std::size_t stride = axis == 0   ? static_cast<std::size_t>(g.size.y) * static_cast<std::size_t>(g.size.z)
                               : axis == 1 ? static_cast<std::size_t>(g.size.z)
                                           : 1;
    const int outer = axis == 0 ? g.size.y : g.size.x;
    const int inner = axis == 2 ? g.size.y : g.size.z;
    tbb::enumerable_thread_specific<std::vector<float>> scratch;
    for_each_slab(outer, [&](int a) {
      std::vector<float>& lines = scratch.local();
      for (int b = 0; b < inner; b += axis == 2 ? 1 : kWide) {
        const auto wide = static_cast<std::size_t>(axis == 2 ? 1 : std::min(kWide, inner - b));
        lines.resize(static_cast<std::size_t>(n + 2 * r) * wide);
        const std::size_t start = axis == 0 ? g.index(0, a, b) : axis == 1 ? g.index(a, 0, b) : g.index(a, b, 0);
        for (int k = 0; k < n + 2 * r; ++k) {
          std::copy_n(&out.v[start + stride * static_cast<std::size_t>(std::clamp(k - r, 0, n - 1))], wide,
                      &lines[static_cast<std::size_t>(k) * wide]);
        }
        const float w = kernel[0];
        for (int k = 0; k < n; ++k) {
          const float* c = &lines[static_cast<std::size_t>(k + r) * wide];
          float* const to = &out.v[start + stride * static_cast<std::size_t>(k)];
          for (std::size_t j = 0; j < wide; ++j) to[j] = w * c[j];
          for (std::size_t m = 1; m <= static_cast<std::size_t>(r); ++m) {
            const float *up = c + m * wide, *down = c - m * wide;
            for (std::size_t j = 0; j < wide; ++j) to[j] += kernel[m] * (up[j] + down[j]);
          }
        }
      }
    });
  }
  return out;
}

Grid<float> distance_squared_to(const Mask& mask) {
  constexpr float kHuge = 1e12F;
  Grid<float> d(mask.size);
  for (std::size_t i = 0; i < d.v.size(); ++i) d.v[i] = mask.v[i] ? 0.0F : kHuge;
  for (int axis = 2; axis >= 0; --axis) {
    const int n = mask.size[axis];
    const std::size_t stride = axis == 0 ? static_cast<std::size_t>(mask.size.y) * static_cast<std::size_t>(mask.size.z)
                               : axis == 1 ? static_cast<std::size_t>(mask.size.z)
                                           : 1;
    const int outer = axis == 0 ? mask.size.y : mask.size.x;
    const int inner = axis == 2 ? mask.size.y : mask.size.z;
    for_each_slab(outer, [&](int a) {
      const auto length = static_cast<std::size_t>(n);
      std::vector<double> f(length), bound(length + 1);
      std::vector<int> parabola(length);
      for (int b = 0; b < inner; ++b) {
        const std::size_t start = axis == 0 ? d.index(0, a, b) : axis == 1 ? d.index(a, 0, b) : d.index(a, b, 0);
        for (std::size_t k = 0; k < length; ++k) f[k] = d.v[start + stride * k];
        // Lower envelope of the parabolas f[q] + (k − q)².
        int top = -1;
        for (int q = 0; q < n; ++q) {
          if (f[static_cast<std::size_t>(q)] >= kHuge) continue;
          double s = -std::numeric_limits<double>::infinity();
          while (top >= 0) {
            const int p = parabola[static_cast<std::size_t>(top)];
            s = (f[static_cast<std::size_t>(q)] + 1.0 * q * q - f[static_cast<std::size_t>(p)] - 1.0 * p * p) /
                (2.0 * (q - p));
            if (s > bound[static_cast<std::size_t>(top)]) break;
            --top;
          }
          ++top;
          parabola[static_cast<std::size_t>(top)] = q;
          bound[static_cast<std::size_t>(top)] = top == 0 ? -std::numeric_limits<double>::infinity() : s;
          bound[static_cast<std::size_t>(top) + 1] = std::numeric_limits<double>::infinity();
        }
        if (top < 0) continue;
        int k = 0;
        for (int q = 0; q < n; ++q) {
          while (bound[static_cast<std::size_t>(k) + 1] < q) ++k;
          const int p = parabola[static_cast<std::size_t>(k)];
          d.v[start + stride * static_cast<std::size_t>(q)] =
              static_cast<float>(f[static_cast<std::size_t>(p)] + 1.0 * (q - p) * (q - p));
        }
      }
    });
  }
  return d;
}

std::int32_t Components::largest() const {
  if (voxels.size() < 2) return 0;
  return static_cast<std::int32_t>(std::max_element(voxels.begin() + 1, voxels.end()) - voxels.begin());
}

Components components(const Mask& mask) {
  Components c;
  c.label = Grid<std::int32_t>(mask.size, 0);
  c.voxels.assign(1, 0);
  const std::array<glm::ivec3, 6> neighbours = {
      glm::ivec3(-1, 0, 0), {0, -1, 0}, {0, 0, -1}, {0, 0, 1}, {0, 1, 0}, {1, 0, 0}};
  std::vector<std::size_t> stack;
  for (std::size_t seed = 0; seed < mask.v.size(); ++seed) {
    if (!mask.v[seed] || c.label.v[seed]) continue;
    const auto id = static_cast<std::int32_t>(c.voxels.size());
    c.voxels.push_back(0);
    c.label.v[seed] = id;
    stack.push_back(seed);
    while (!stack.empty()) {
      const std::size_t i = stack.back();
      stack.pop_back();
      ++c.voxels.back();
      const glm::ivec3 p = mask.place(i);
      for (const glm::ivec3& step : neighbours) {
        const glm::ivec3 q = p + step;
        if (!mask.holds(q)) continue;
        const std::size_t j = mask.index(q);
        if (mask.v[j] && !c.label.v[j]) {
          c.label.v[j] = id;
          stack.push_back(j);
        }
      }
    }
  }
  return c;
}

}  // namespace typodont::haptics::importing
