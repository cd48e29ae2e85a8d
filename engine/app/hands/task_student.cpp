#include "engine/app/hands/task_student.h"

#include <algorithm>
#include <cmath>

#include "haptics/sweep.h"

namespace typodont {

namespace {

constexpr double kClear = 0.05;   // voxels that a head may reach into what should stay: the field's own error
constexpr double kLook = 0.1e-3;  // m between looks along a row

}  // namespace

dquat toward(const dvec3& axis_W) {
  const dvec3 z(0, 0, 1), a = glm::normalize(axis_W);
  const dvec3 turn = glm::cross(z, a);
  const double s = glm::length(turn), c = glm::dot(z, a);
  if (s < 1e-12) return c > 0 ? dquat(1, 0, 0, 0) : dquat(0, 1, 0, 0);
  return glm::angleAxis(std::atan2(s, c), turn / s);
}

std::vector<Stroke> plan_strokes(const session::Preparation& in, const haptics::Tool& tool, double step, double into) {
  const session::DenseField ideal = session::redistanced(in.ideal);
  const dquat R_WT = toward(in.axis_W);
  const dvec3 u = R_WT * dvec3(1, 0, 0), v = R_WT * dvec3(0, 1, 0), w = R_WT * dvec3(0, 0, 1);
  std::vector<dvec3> head{dvec3(0)};
  for (const haptics::HeadSample& sample : haptics::sample_head(tool, 80)) head.push_back(R_WT * sample.p_TQ);

  // How far the head reaches into what should stay, and whether it has anything to take here.
  const double allowed = kClear + into / in.frame.voxel;
  const auto clear_at = [&](const dvec3& p_W) {
    return std::all_of(head.begin(), head.end(),
                       [&](const dvec3& h) { return ideal.sample(in.frame.to_voxels(p_W + h)) > -allowed; });
  };
  const auto useful_at = [&](const dvec3& p_W) {
    return std::any_of(head.begin(), head.end(), [&](const dvec3& h) {
      const dvec3 p = in.frame.to_voxels(p_W + h);
      return in.before.sample(p) < 0.3 && ideal.sample(p) > 0;
    });
  };

  // Where anything is to be taken away, along the three axes.
  dvec3 lo(1e9), hi(-1e9);
  for (int x = 0; x < in.before.size.x; ++x) {
    for (int y = 0; y < in.before.size.y; ++y) {
      for (int z = 0; z < in.before.size.z; ++z) {
        const std::size_t i = in.before.at(x, y, z);
        if (in.before.distance[i] > 0 || in.ideal.distance[i] <= 0) continue;
        const dvec3 p = in.frame.to_world(dvec3(x, y, z)), q(glm::dot(p, u), glm::dot(p, v), glm::dot(p, w));
        lo = glm::min(lo, q);
        hi = glm::max(hi, q);
      }
    }
  }
  std::vector<Stroke> strokes;
  if (lo.x > hi.x) return strokes;
  lo -= tool.radius();
  hi += tool.radius();

  // The last clear place between a clear and an unclear one.
  const auto border = [&](dvec3 clear, dvec3 not_clear) {
    for (int k = 0; k < 6; ++k) {
      const dvec3 middle = 0.5 * (clear + not_clear);
      (clear_at(middle) ? clear : not_clear) = middle;
    }
    return clear;
  };
  const auto rows = [&](double height, const dvec3& along, double a0, double a1, const dvec3& across, double b0,
                        double b1) {
    bool back = false;
    for (double b = b0; b <= b1; b += step) {
      std::vector<Stroke> row;
      const auto at = [&](double a) { return a * along + b * across + height * w; };
      bool open = false, useful = false;
      dvec3 from(0);
      for (double a = a0; a <= a1 + kLook; a += kLook) {
        const bool clear = a <= a1 && clear_at(at(a));
        if (clear) useful = useful || useful_at(at(a));
        if (clear && !open) from = a > a0 ? border(at(a), at(a - kLook)) : at(a);
        if (!clear && open && useful) row.push_back({{from, R_WT}, {border(at(a - kLook), at(a)), R_WT}});
        if (!clear) useful = false;
        open = clear;
      }
      if (back) {
        std::reverse(row.begin(), row.end());
        for (Stroke& s : row) std::swap(s.from, s.to);
      }
      strokes.insert(strokes.end(), row.begin(), row.end());
      if (!row.empty()) back = !back;
    }
  };
  for (double height = hi.z + tool.reach(); height > lo.z; height -= step) {
    rows(height, u, lo.x, hi.x, v, lo.y, hi.y);
    rows(height, v, lo.y, hi.y, u, lo.x, hi.x);
  }
  // Down to the floor, which lies between two layers.
  for (double b = lo.y; b <= hi.y; b += step) {
    for (double a = lo.x; a <= hi.x; a += step) {
      const auto at = [&](double height) { return a * u + b * v + height * w; };
      double lowest = hi.z + tool.reach();
      if (!clear_at(at(lowest))) continue;
      while (lowest > lo.z && clear_at(at(lowest - kLook))) lowest -= kLook;
      if (lowest <= lo.z || !useful_at(at(lowest))) continue;
      const dvec3 floor = border(at(lowest), at(lowest - kLook));
      strokes.push_back({{at(lowest), R_WT}, {floor, R_WT}});
    }
  }
  return strokes;
}

void carve_strokes(haptics::TissueVolume& volume, const haptics::Tool& tool, const std::vector<Stroke>& strokes) {
  for (const Stroke& s : strokes) volume.carve(haptics::Sweep(tool, s.from, s.to, volume.frame()));
}

}  // namespace typodont
