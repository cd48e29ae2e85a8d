#include "haptics/import/grid.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace typodont::haptics::importing {

void for_each_in_parallel(std::size_t n, const std::function<void(std::size_t)>& work) {
  tbb::parallel_for(std::size_t{0}, n, work);
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
    for_each_in_parallel(outer, [&](int a) {
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

}  // namespace typodont::haptics::importing
