// Finds the grey values of tissues in a scan's histogram.
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
  // Grey value of enamel or cortical bone; empty: the scan shows only one tissue.
  std::optional<double> dense;
  // True if `dense` was given by the user or by Hounsfield units.
  bool fixed_dense = false;
  // True if `outside` was given by the user or by Hounsfield units. `outside` is then the grey value of thin soft
  // tissue over the bone; the air around it is darker.
  bool fixed_surround = false;
  // Grey value above which voxels are tooth. The largest body with teeth is imported; empty: simply the largest body.
  std::optional<double> tooth;
  // Smallest volume brighter than `tooth` that counts as teeth, m³.
  static constexpr double kMinTeeth = 8e-9;
  // Grey value of the surface as a fraction: 0 is `outside`, 1 is `soft`.
  double height = 0.5;
  std::optional<double> hounsfield;  // grey value of 0 Hounsfield units; empty: unknown
  double noise = 0;                  // standard deviation of the grey values in the surroundings
  double smoothed_noise = 0;         // standard deviation in the surroundings after smoothing

  /// Grey value of the surface: the user's threshold, or half-way between `outside` and `soft`, where a blurred edge
  /// truly lies.
  double surface() const { return outside + height * (soft - outside); }
  double denser() const { return 0.5 * (soft + *dense); }
  double top() const { return dense.value_or(soft); }
};

struct Peak {
  double level;  // grey value of the peak
  double mass;   // fraction of all voxels whose grey value lies between the two minima of the histogram beside the peak
};
/// Finds the peaks of the histogram, from dark to bright. `blur`: standard deviation of the noise.
std::vector<Peak> peaks_of(const Grid<float>& greys, double blur);

/// Finds the grey values. `smoothed`: the scan after slight smoothing. Throws Error if there is no tissue.
Levels find_levels(const std::filesystem::path& file, const Grid<float>& grey, const Grid<float>& smoothed,
                   const ImportOptions& options, std::vector<std::string>& notes);

}  // namespace typodont::haptics::importing
