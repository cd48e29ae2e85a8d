// Grey values of surroundings and tissues, from the histogram.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "haptics/import/grid.h"
#include "haptics/import/import.h"

namespace typodont::haptics::importing {

struct Levels {
  double outside = 0;  // grey value of the surroundings
  double soft = 0;     // grey value of the softer tissue (dentin, cancellous bone)
  // enamel, cortical bone; empty: one tissue
  std::optional<double> dense;
  // given by the user or by Hounsfield units
  bool fixed_dense = false;
  // thin soft tissue over bone is `outside`; the air beyond is darker
  bool fixed_surround = false;
  // Brighter: tooth. The largest body with teeth is imported; empty: the largest.
  std::optional<double> tooth;
  // m³ brighter than `tooth`
  static constexpr double kLeastTeeth = 8e-9;
  // of the surface, 0: outside, 1: soft
  double height = 0.5;
  std::optional<double> hounsfield;  // of 0 Hounsfield units; empty: unknown
  double noise = 0;                  // standard deviation of the grey values in the surroundings
  double smoothed_noise = 0;         // σ in the surroundings, smoothed

  /// Half-way, where a blurred edge truly lies, unless the user gives it.
  double surface() const { return outside + height * (soft - outside); }
  double denser() const { return 0.5 * (soft + *dense); }
  double top() const { return dense.value_or(soft); }
};

struct Peak {
  double level;  // grey value of the peak
  double mass;   // of all voxels, between its valleys
};
/// Dark to bright. `blur`: σ of the noise.
std::vector<Peak> peaks_of(const Grid<float>& greys, double blur);

/// `smoothed`: slightly. Throws Error without tissue.
Levels find_levels(const std::filesystem::path& file, const Grid<float>& grey, const Grid<float>& smoothed,
                   const ImportOptions& options, std::vector<std::string>& notes);

}  // namespace typodont::haptics::importing
