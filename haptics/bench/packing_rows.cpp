// Measures sphere packings (paper S2 in docs/papers.md): the filled fraction of the tissue, and the time and accuracy
// of contact and cutting.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/measure.h"
#include "engine/base/units.h"
#include "haptics/bench.h"
#include "haptics/bench/scene.h"
#include "haptics/bench/timing.h"
#include "haptics/contact/packing/compute_passes.h"
#include "haptics/contact/packing/packing_body.h"
#include "haptics/contact/packing/packing_model.h"
#include "haptics/contact/packing/sphere_tissue.h"
#include "haptics/contact/packing/surface_estimate.h"
#include "haptics/contact/packing/tool_spheres.h"
#include "haptics/lockstep.h"
#include "haptics/solid.h"
#include "haptics/sphere_packer.h"

namespace typodont::haptics {

namespace {

using namespace packing;

constexpr double kBall = 5e-3;    // m, radius of the tissue, which is a ball
constexpr double kHead = 0.6e-3;  // m, radius of a round bur
// m; the tool's spheres are enlarged by this when they are used to estimate the tissue's surface at the contact
constexpr double kDepth = 0.1e-3;
constexpr std::size_t kToolSpheres = 200;
constexpr double kReamer = 22e-3;  // m, radius of the reamer
// m, initial height of the reamer's centre: 1 mm above its height at the first contact
constexpr double kReamerStart = 16.5e-3;

DenseTissue ball_field() {
  return read_solids(Json::parse(
      R"({"voxel_mm": 0.1, "solids": [{"tissue": "dentin", "solid": {"sphere": {"radius_mm": 5}}}]})", "bench"));
}

/// Returns a pseudo-random unit vector. Equal seeds give equal vectors.
dvec3 direction(std::mt19937_64& random) {
  std::uniform_real_distribution<double> u(-1, 1);
  while (true) {
    const double x = u(random), y = u(random), z = u(random);
    const double length = glm::length(dvec3(x, y, z));
    if (length > 0.1 && length < 1) return dvec3(x, y, z) / length;
  }
}

/// Returns the volume, in m³, of the part of the ball that lies within `r` of the segment from a to b. It is computed
/// by counting the points of a grid.
double exact_groove(const dvec3& a, const dvec3& b, double r) {
  constexpr double h = 0.02e-3;
  const dvec3 lo = glm::min(a, b) - r, hi = glm::max(a, b) + r;
  std::size_t count = 0;
  for (double x = lo.x + h / 2; x < hi.x; x += h) {
    for (double y = lo.y + h / 2; y < hi.y; y += h) {
      for (double z = lo.z + h / 2; z < hi.z; z += h) {
        const dvec3 p(x, y, z);
        count += glm::dot(p, p) <= kBall * kBall && glm::distance(p, nearest_on(a, b, p)) <= r;
      }
    }
  }
  return static_cast<double>(count) * h * h * h;
}

/// The contact model "packing" with a packing that was computed before.
class PackedMethod final : public ContactMethod {
 public:
  explicit PackedMethod(const SpherePacking& packing) : packing_(packing) { parameters_.spheres = packing.size(); }
  std::string_view name() const override { return "packing"; }
  std::unique_ptr<ContactModel> make_model(const ServoSettings& settings) const override {
    return std::make_unique<PackingModel>(settings, parameters_);
  }
  std::unique_ptr<TissueBody> make_body(TissueVolume tissue, std::span<const Tool> tools) const override {
    return std::make_unique<PackingBody>(std::move(tissue), packing_, tools, parameters_);
  }

 private:
  const SpherePacking& packing_;
  Parameters parameters_;
};

/// Returns a block of bone with a socket that is 0.5 mm wider than the reamer.
DenseTissue socket_field() {
  return read_solids(Json::parse(R"({"voxel_mm": 0.8, "band_mm": 4, "solids": [{"tissue": "cancellous_bone",
      "solid": {"difference": [{"box": {"size_mm": [56, 56, 32]}},
      {"sphere": {"center_mm": [0, 0, 16], "radius_mm": 22.5}}]}}]})",
                                 "bench"));
}

class Rows {
 public:
  Rows(std::vector<BenchRow>& rows, const TissueVolume& tissue) : rows_(rows), tissue_(tissue) {}

  void of(const SpherePacking& packing, bool quick) {
    size_ = static_cast<double>(packing.size());
    knob_ = fmt::format("{} spheres", packing.size());
    collision(packing, quick);
    direction_of_normal(packing, quick);
    removal(packing);
    passes(packing, quick);
    ticks(packing, quick);
  }
  void add(const char* name, double error, const char* unit, double ns, const char* per, const char* baseline = "",
           double of_it = 0) {
    rows_.push_back(
        {name, knob_, error, unit, ns, per, baseline, of_it > 0 ? ns / of_it : BenchRow::kNone, size_, "spheres"});
  }
  void packed(const SpherePacking& packing, double seconds) {
    size_ = static_cast<double>(packing.size());
    knob_ = fmt::format("{} spheres", packing.size());
    add("packing a ball of 10 mm", 1 - packing.coverage(), "share left unfilled", 1e9 * seconds / size_, "sphere");
    add("packing a ball of 10 mm, largest hole", packing.largest_hole / kMillimetre, "mm, radius", BenchRow::kNone, "");
  }

 private:
  /// Moves a tool of many spheres through the surface. Compares three searches: with a tree over the tissue's spheres,
  /// with a tree over the tool's spheres, and without a tree.
  void collision(const SpherePacking& packing, bool quick) {
    Tool head;
    head.shape = HeadShape::kCylinder, head.diameter = 1e-3, head.length = 4e-3;
    const ToolSpheres tool = tool_spheres(head, kToolSpheres);
    const SphereTree tissue(packing.center, packing.radius), of_tool(tool.center_T, tool.radius);
    std::mt19937_64 random(1);
    const int looks = quick ? 5 : 40;
    std::vector<double> by_tissue, by_tool, by_none;
    for (int i = 0; i < looks; ++i) {
      const dvec3 from = (kBall + 0.55e-3) * direction(random), way = 0.2e-3 * direction(random) - 0.02 * from;
      double first[3] = {kNever, kNever, kNever};
      Nanos start = thread_cpu_time();
      for (std::size_t t = 0; t < tool.radius.size(); ++t) {
        first[0] = std::min(first[0], tissue.first_hit(from + tool.center_T[t], tool.radius[t], way).t);
      }
      by_tissue.push_back(static_cast<double>(thread_cpu_time() - start));
      start = thread_cpu_time();
      for (std::size_t b = 0; b < packing.size(); ++b) {
        first[1] = std::min(first[1], of_tool.first_hit(packing.center[b] - from, packing.radius[b], -way).t);
      }
      by_tool.push_back(static_cast<double>(thread_cpu_time() - start));
      // The search without a tree is slow, and its time does not vary, so two runs of it are sufficient.
      if (i >= 2) continue;
      start = thread_cpu_time();
      for (std::size_t t = 0; t < tool.radius.size(); ++t) {
        first[2] = std::min(first[2], tissue.brute_force(from + tool.center_T[t], tool.radius[t], way).t);
      }
      by_none.push_back(static_cast<double>(thread_cpu_time() - start));
      differ_ = differ_ || first[0] != first[2];
    }
    const double none = quantile(by_none, 0.5);
    add("first contact of 200 tool spheres, tree over the tissue", differ_ ? 1 : 0, "results that differ",
        quantile(by_tissue, 0.5), "look", "every pair", none);
    add("first contact of 200 tool spheres, tree over the tool", BenchRow::kNone, "", quantile(by_tool, 0.5), "look",
        "every pair", none);
    add("memory", BenchRow::kNone, "", BenchRow::kNone, "");
    rows_.back().error = static_cast<double>(SphereTissue(packing, Removal::kMended).bytes()) / size_;
    rows_.back().error_unit = "bytes a sphere, tree included";
  }

  void direction_of_normal(const SpherePacking& packing, bool quick) {
    const SphereTissue tissue(packing, Removal::kMended);
    const ToolSpheres tool({dvec3(0)}, {kHead});
    PerTissue density{};
    density.fill(1);
    std::vector<Place> scratch(packing.size());
    std::mt19937_64 random(2);
    const int looks = quick ? 50 : 500;
    double squares = 0;
    std::vector<double> times;
    for (int i = 0; i < looks; ++i) {
      const dvec3 out = direction(random);
      const Nanos start = thread_cpu_time();
      const SurfaceEstimate e =
          estimate_surface(tissue, tool, {(kBall + kHead) * out, {1, 0, 0, 0}}, kBall * out, kDepth, density, scratch);
      times.push_back(static_cast<double>(thread_cpu_time() - start));
      squares += std::pow(std::asin(std::min(1.0, glm::length(glm::cross(e.n_W, out)))) / kDegree, 2) / looks;
    }
    add("normal and density by overlap (2)(3) on a ball", std::sqrt(squares), "degree, rms", quantile(times, 0.5),
        "look");
  }

  /// Measures the three passes of a tick (first contact, surface estimate, removal) separately, on the CPU and on a
  /// Vulkan device. Does nothing if there is no such device.
  void passes(const SpherePacking& packing, bool quick) {
    std::unique_ptr<SpherePasses> on_device = make_sphere_passes(packing.size(), true);
    if (!on_device) return;
    Tool head;
    head.shape = HeadShape::kCylinder, head.diameter = 1e-3, head.length = 4e-3;
    const ToolSpheres tool = tool_spheres(head, kToolSpheres);
    const SphereTissue tissue(packing, Removal::kMended);
    ComputePasses passes(std::move(on_device), {&tool, 1});
    passes.load(tissue);
    CutBuffers buffers(packing.size());
    const PassTimes times = compare_passes(tissue, tool, passes, buffers, quick ? 3 : 20);
    add("three passes of 200 tool spheres, processor", BenchRow::kNone, "", 1e9 * times.processor, "tick");
    const std::string name = "three passes of 200 tool spheres, " + passes.device();
    add(name.c_str(), times.same ? 0 : 1, "results that differ", 1e9 * times.gpu, "tick", "processor",
        1e9 * times.processor);
  }

  void removal(const SpherePacking& packing) {
    const dvec3 n = glm::normalize(dvec3(0.3, -0.5, 0.8)), along = glm::normalize(glm::cross(n, dvec3(1, 0, 0.2)));
    const dvec3 a = 4.8e-3 * n - 2e-3 * along, b = 4.8e-3 * n + 2e-3 * along;
    const double exact = exact_groove(a, b, kHead);
    std::vector<Place> changed(packing.size());
    const std::vector<double> cell = cell_volumes(packing, SphereTree(packing.center, packing.radius), tissue_);
    for (const Removal form : {Removal::kMended, Removal::kAsPrinted}) {
      SphereTissue tissue(packing, form, cell);
      Removed removed;
      constexpr int kSteps = 400;
      const Nanos start = thread_cpu_time();
      for (int i = 0; i < kSteps; ++i) {
        tissue.cut(glm::mix(a, b, static_cast<double>(i) / kSteps), glm::mix(a, b, static_cast<double>(i + 1) / kSteps),
                   kHead, changed, {}, removed);
      }
      const double ns = static_cast<double>(thread_cpu_time() - start) / kSteps;
      double sum = 0;
      for (const double v : removed.volume) sum += v;
      add(form == Removal::kMended ? "removal (6), a groove, corrected formula"
                                   : "removal (6), a groove, published formula",
          sum / exact - 1, "share of the exact volume, too much", ns, "cut");
    }
  }

  /// Measures complete ticks of a servo with the model "packing". A round bur is pressed onto the ball and moved over
  /// it.
  void ticks(const SpherePacking& packing, bool quick) {
    const int count = quick ? 1000 : 5000;
    ServoSettings settings;
    settings.tool.diameter = settings.tool.length = 2 * kHead;
    settings.spindle.free_speed = 300 * kKrpm;
    // J/m³, specific cutting energy of dentin in this benchmark
    settings.materials[static_cast<std::size_t>(Tissue::kDentin)].specific_energy = 8e9;
    settings.method = std::make_shared<PackedMethod>(packing);
    const std::vector<double> times = bench::least_of([&] {
      return bench::servo_times(TissueVolume(ball_field()), settings, 1, count, [](int i, const ServoTick&) {
        const double angle = 0.8 * std::sin(0.002 * i), deep = std::min(0.5e-3, 1e-6 * i);
        return (kBall + kHead + 0.1e-3 - deep) * dvec3(std::sin(angle), 0.1 * std::sin(0.003 * i), std::cos(angle));
      });
    });
    add("cutting tick, median", BenchRow::kNone, "", quantile(times, 0.5), "tick");
    add("cutting tick, 99.9 %", BenchRow::kNone, "", quantile(times, 0.999), "tick");
  }

 public:
  /// Measures complete ticks of a servo whose reamer a hand presses into a socket with 180 N.
  void reaming(const DenseTissue& socket, const SpherePacking& packing, bool quick) {
    const int count = quick ? 1000 : 5000;
    ServoSettings settings;
    settings.tool.diameter = settings.tool.length = 2 * kReamer;
    settings.spindle.free_speed = 0.3 * kKrpm;
    settings.stiffness = 60e3, settings.damping = 20;
    settings.force_limit = 250, settings.torque_limit = 10;
    // stiffness in N/m, and specific cutting energy in J/m³, of all tissues
    for (Material& m : settings.materials) m.stiffness = 1000, m.specific_energy = 0.4e9;
    settings.method = std::make_shared<PackedMethod>(packing);
    const std::vector<double> times = bench::least_of([&] {
      dvec3 x(0, 0, kReamerStart), v(0);
      return bench::servo_times(TissueVolume(DenseTissue(socket)), settings, 1, count, [&](int, const ServoTick& last) {
        // The hand has a mass of 3 kg, a damping of 1000 N·s/m, and a stiffness of 20 N/mm across the axis.
        const dvec3 pull(-20e3 * x.x, -20e3 * x.y, -180);
        v += 1e-3 * (pull - 1000.0 * v + last.f_T_W) / 3.0;
        return x += 1e-3 * v;
      });
    });
    add("reaming tick, median", BenchRow::kNone, "", quantile(times, 0.5), "tick");
    add("reaming tick, mean", BenchRow::kNone, "",
        std::accumulate(times.begin(), times.end(), 0.0) / static_cast<double>(times.size()), "tick");
    add("reaming tick, 99.9 %", BenchRow::kNone, "", quantile(times, 0.999), "tick");
  }

 private:
  std::vector<BenchRow>& rows_;
  const TissueVolume& tissue_;
  std::string knob_;
  double size_ = 0;
  bool differ_ = false;
};

/// Fits the function c · n^p to the times of the rows with this name, by least squares of the logarithms. n: number of
/// spheres; c, p: fitted numbers. Adds a row with p.
void add_growth(const std::string& name, std::vector<BenchRow>& rows) {
  double x = 0, y = 0, xx = 0, xy = 0, k = 0;
  for (const BenchRow& row : rows) {
    if (row.name != name) continue;
    const double u = std::log(row.size), v = std::log(row.time_ns);
    x += u, y += v, xx += u * u, xy += u * v, k += 1;
  }
  rows.push_back({name + ", growth", "time = c · spheres^p", (k * xy - x * y) / (k * xx - x * x), "p"});
}

}  // namespace

std::vector<BenchRow> bench_packing(bool quick) {
  std::vector<BenchRow> rows;
  const TissueVolume field(ball_field());
  const DenseTissue socket = socket_field();
  Rows measured(rows, field);
  std::vector<std::size_t> sizes = {10000, 36000};
  if (!quick) sizes.push_back(300000);
  for (const std::size_t n : sizes) {
    PackOptions options;
    options.spheres = n;
    const Nanos start = thread_cpu_time();
    const SpherePacking packing = pack_spheres(field, options);
    measured.packed(packing, to_seconds(thread_cpu_time() - start));
    measured.of(packing, quick);
    measured.reaming(socket, pack_spheres(TissueVolume(DenseTissue(socket)), options), quick);
  }
  add_growth("cutting tick, median", rows);
  add_growth("reaming tick, mean", rows);
  return rows;
}

}  // namespace typodont::haptics
