#include "audio/voice/derive.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "audio/ar/levinson.h"

namespace typodont::audio {

namespace {

/// How a tissue changes the idle sound. Brittle tissue changes level and slope, bone and dentin add a lower resonance,
/// soft tissue damps. See audio/README.md.
struct TissueColour {
  double level_dB;       // dB, power of the sound in this tissue relative to that of the idle sound, both at free speed
  double slope_dB;       // dB per octave, slope of the gain from 200 Hz to 16 kHz, 0 dB at 3 kHz
  double centre;         // Hz, centre frequency of the tissue's resonance
  double resonance_dB;   // dB, gain at the centre of the resonance
  double width_octaves;  // octaves, standard deviation of the Gaussian resonance curve
};
constexpr std::array<TissueColour, kTissueCount> kColours = {{
    {0.0, 0.0, 3000, 0.0, 1.0},   // air: the idle sound, unchanged
    {6.0, 1.6, 9000, 4.0, 0.5},   // enamel
    {5.0, 0.3, 5000, 3.0, 0.6},   // dentin
    {3.0, -1.5, 2500, 2.0, 0.8},  // caries
    {1.0, -3.0, 1500, 1.0, 1.0},  // pulp
    {5.5, 0.8, 4000, 4.0, 0.5},   // cortical bone
    {4.0, -1.0, 2000, 3.0, 0.8},  // cancellous bone
    {0.5, -4.0, 800, 0.0, 1.0},   // gingiva
    {6.0, 1.2, 7000, 6.0, 0.25},  // amalgam
    {4.0, 0.0, 4000, 2.0, 0.7},   // composite
}};

/// Factor by which a tissue changes the power at `frequency` (Hz), without the tissue's change of the overall level.
double power_factor(const TissueColour& colour, double frequency) {
  const double f = std::clamp(frequency, 200.0, 16000.0);
  const double away = std::log2(f / colour.centre) / colour.width_octaves;
  const double dB = colour.slope_dB * std::log2(f / 3000) + colour.resonance_dB * std::exp(-0.5 * away * away);
  return std::pow(10, dB / 10);
}

}  // namespace

std::array<ArModel, kTissueCount> derived_working_models(const ArModel& idle) {
  constexpr std::size_t kPoints = 16385;
  const auto idle_power = sampled_power(idle.reflection, idle.gain, kPoints);
  // Power of a spectral line × kPoints, comparable with the sum of a power spectrum over kPoints frequencies.
  const auto power_of_line = [](const ModelLine& line) { return line.amplitude * line.amplitude / 2 * kPoints; };
  double before = std::accumulate(idle_power.begin(), idle_power.end(), 0.0);
  for (const ModelLine& line : idle.lines) before += power_of_line(line);
  std::array<ArModel, kTissueCount> models;
  models.fill(idle);
  for (std::size_t t = 1; t < models.size(); ++t) {
    const TissueColour& colour = kColours[t];
    auto power = idle_power;
    for (std::size_t i = 0; i < kPoints; ++i) {
      power[i] *= power_factor(colour, static_cast<double>(i) / (kPoints - 1) * idle.rate / 2);
    }
    // Scales the power to level_dB. A floor 100 dB below the idle sound keeps Levinson's recursion well-conditioned.
    double after = std::accumulate(power.begin(), power.end(), 0.0);
    for (const ModelLine& line : idle.lines) after += power_of_line(line) * power_factor(colour, line.frequency);
    const double scale = before / after * std::pow(10, colour.level_dB / 10);
    const double floor = 1e-10 * before / static_cast<double>(kPoints);
    for (double& v : power) v = v * scale + floor;
    models[t].reflection = reflection_of_power(power, idle.order(), models[t].gain);
    for (ModelLine& line : models[t].lines) line.amplitude *= std::sqrt(scale * power_factor(colour, line.frequency));
    models[t].method = "derived";
    models[t].name = idle.name + " in " + std::string(name_of(static_cast<Tissue>(t)));
  }
  return models;
}

}  // namespace typodont::audio
