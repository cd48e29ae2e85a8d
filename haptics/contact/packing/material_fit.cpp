#include "haptics/material_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "engine/base/error.h"
#include "haptics/contact/packing/packing_method.h"
#include "haptics/contact/packing/packing_parts.h"

namespace typodont::haptics {

namespace {

using namespace packing;

/// One time interval of the recorded force, with the tissue that the tool removes during it.
struct Moment {
  double t = 0, measured = 0;  // s, start of the interval; N, mean measured force
  // tissue spheres that the tool overlaps: index, and overlap in m³
  std::vector<std::pair<int, double>> overlap;
  double gain = 0;  // N, force if all spheres had density 1
};

/// Returns force / cutting power (N/W) by Preston's law, as in Servo::State::earn(): power = μ_c · efficiency · force F
/// · head's radius R · speed ω. Ignores the motor's loss of speed under load.
double newtons_per_watt(const ServoSettings& settings, const Pose& X_WT, const dvec3& feed) {
  const Tool& tool = settings.tool;
  const double along = glm::dot(glm::normalize(feed), X_WT.R * dvec3(0, 0, 1));
  const double efficiency = tool.side_efficiency + (tool.end_efficiency - tool.side_efficiency) * along * along;
  return 1 / (tool.cutting_coefficient * efficiency * tool.radius() * settings.spindle.free_speed);
}

}  // namespace

double stability_of(std::span<const std::pair<int, double>> overlap, double gain, double eta) noexcept {
  double sum = 0, squares = 0;
  for (const auto& [i, v] : overlap) sum += v, squares += v * v;
  return sum > 0 ? eta * gain * squares / (sum * sum) : 0;
}

double adjust_densities(std::span<const std::pair<int, double>> overlap, double gain, double eta, double measured,
                        std::span<double> rho) noexcept {
  double sum = 0, weighted = 0;
  for (const auto& [i, v] : overlap) sum += v, weighted += v * rho[static_cast<std::size_t>(i)];
  if (!(sum > 0)) return 0;
  const double simulated = gain * weighted / sum;
  for (const auto& [i, v] : overlap) rho[static_cast<std::size_t>(i)] += eta * (measured - simulated) * v / sum;
  return simulated;
}

MaterialFit fit_material(const TissueVolume& tissue, const ServoSettings& settings, std::span<const FeedSample> samples,
                         const FitOptions& options, std::string_view curve) {
  const std::optional<Packed> packed = packed_by(settings.method, tissue);
  if (!packed)
    throw Error(std::string(curve), "model", std::string(settings.method ? settings.method->name() : "offset"),
                "packing");
  const SpherePacking& packing = packed->packing;
  const Parameters& parameters = packed->parameters;
  const ToolSpheres tool = spheres_of(tool_set(settings), 0, parameters);
  const PerTissue density = densities(parameters, settings.materials);
  const double dentin = settings.materials[static_cast<std::size_t>(Tissue::kDentin)].specific_energy;

  // Computes the removed tissue of each interval once, because it does not depend on the densities.
  SphereTissue spheres(packing, parameters.removal,
                       cell_volumes(packing, SphereTree(packing.center, packing.radius), tissue));
  CutBuffers buffers(packing.size());
  std::vector<Moment> moments;
  const std::size_t every = std::max<std::size_t>(1, samples.size() / static_cast<std::size_t>(options.moments));
  for (std::size_t begin = 0; begin + 1 < samples.size(); begin += every) {
    const std::size_t end = std::min(begin + every, samples.size() - 1);
    const double seconds = samples[end].t - samples[begin].t;
    const dvec3 feed = samples[end].X_WT.p - samples[begin].X_WT.p;
    if (!(seconds > 0) || !(glm::length(feed) > 0)) continue;
    Moment moment;
    std::map<int, double> overlap;
    for (std::size_t k = begin; k < end; ++k) {
      moment.measured += samples[k].force / static_cast<double>(end - begin);
      carve(spheres, tool, samples[k].X_WT, samples[k + 1].X_WT, buffers, [&](Place place, const CutSphere& before) {
        overlap[spheres.tree().sphere_in(place)] += before.volume - spheres.sphere(place).volume;
      });
    }
    double taken = 0;
    for (const auto& [i, v] : overlap) {
      if (v > 0) moment.overlap.emplace_back(i, v), taken += v;
    }
    if (!(taken > 0)) continue;
    moment.t = samples[begin].t;
    moment.gain = newtons_per_watt(settings, samples[begin].X_WT, feed) * dentin * taken / seconds;
    moments.push_back(std::move(moment));
  }
  double most = 0;
  for (const Moment& m : moments) most = std::max(most, m.measured);
  if (moments.empty()) {
    throw Error(std::string(curve), "", "a way on which the tool touches nothing of the tissue",
                "a curve with contact");
  }
  if (!(most > 0))
    throw Error(std::string(curve), "", "no force on the way through the tissue", "a curve with contact");

  MaterialFit fit;
  fit.seed = packing.seed, fit.tissue_hash = packing.tissue_hash;
  double steepest = 0;  // N per density, largest gain × Σ w² of an interval; w: a sphere's share of the overlap
  for (const Moment& m : moments) steepest = std::max(steepest, stability_of(m.overlap, m.gain, 1));
  double eta = options.eta > 0 ? options.eta : options.relaxation / steepest;
  fit.stability = eta * steepest;
  if (!(fit.stability < 2)) {
    throw Error(std::string(curve), "eta",
                fmt::format("{:g} density/N, unstable: eta g sum(w^2) = {:.3g}", eta, fit.stability),
                fmt::format("below {:.3g}, where that is 2", 2 / steepest));
  }

  std::vector<double> rho(packing.size());
  for (std::size_t i = 0; i < rho.size(); ++i) rho[i] = density[static_cast<std::size_t>(packing.tissue[i])];
  fit.fitted.assign(packing.size(), false);
  const auto simulated = [&](const Moment& m) {
    double sum = 0, weighted = 0;
    for (const auto& [i, v] : m.overlap) sum += v, weighted += v * rho[static_cast<std::size_t>(i)];
    return m.gain * weighted / sum;
  };
  const auto mean_square = [&] {
    double sum = 0;
    for (const Moment& m : moments) sum += std::pow(m.measured - simulated(m), 2);
    return sum / static_cast<double>(moments.size());
  };
  fit.error.push_back(mean_square());
  for (int round = 0; round < options.rounds; ++round) {
    const std::vector<double> before = rho;
    for (const Moment& m : moments) {
      adjust_densities(m.overlap, m.gain, eta, m.measured, rho);
      // Densities are at least zero, which means no resistance.
      for (const auto& [i, v] : m.overlap)
        rho[static_cast<std::size_t>(i)] = std::max(0.0, rho[static_cast<std::size_t>(i)]);
    }
    // Each moment's step may be stable and the pass still get worse, because moments share spheres and a curve that no
    // densities give exactly pulls them in different directions. Then half of the step is enough.
    const double error = mean_square();
    const bool worse = options.eta <= 0 && error > fit.error.back();
    if (worse) rho = before, eta /= 2;
    fit.error.push_back(worse ? fit.error.back() : error);
    if (options.progress) options.progress(static_cast<double>(round + 1) / options.rounds);
  }
  if (fit.error.back() > fit.error.front()) {
    throw Error(
        std::string(curve), "eta",
        fmt::format("a mean square error that grew from {:.4g} to {:.4g} N²", fit.error.front(), fit.error.back()),
        fmt::format("below {:.3g} density/N", eta));
  }
  for (const Moment& m : moments) {
    fit.t.push_back(m.t), fit.measured.push_back(m.measured), fit.simulated.push_back(simulated(m));
    for (const auto& [i, v] : m.overlap) fit.fitted[static_cast<std::size_t>(i)] = true;
  }
  fit.hardness.assign(packing.size(), 1.0f);
  for (std::size_t i = 0; i < rho.size(); ++i) {
    const double own = density[static_cast<std::size_t>(packing.tissue[i])];
    if (fit.fitted[i] && own > 0) fit.hardness[i] = static_cast<float>(rho[i] / own);
  }
  return fit;
}

}  // namespace typodont::haptics
