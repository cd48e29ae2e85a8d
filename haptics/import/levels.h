// Finds the grey values of surroundings and tissues in the histogram.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "haptics/import/grid.h"
#include "haptics/import/import.h"

namespace typodont::haptics::importing {

struct Levels {
  double outside = 0;           // grey value of the surroundings
  double soft = 0;              // grey value of the softer tissue (dentin, cancellous bone)
  std::optional<double> dense;  // grey value of the denser tissue (enamel, cortical bone), if there are two tissues
  bool fixed_dense = false;     // the threshold between the two tissues was given, not found
  bool fixed_surround = false;  // thin layers on the tissue that are as bright as `outside` count as surroundings
  double height = 0.5;          // 0..1, position of the surface threshold between the grey values `outside` and `soft`
  std::optional<double> hounsfield;  // grey value of 0 Hounsfield units, if the scale is known
  double noise = 0;                  // standard deviation of the grey values in the surroundings
  double smoothed_noise = 0;         // standard deviation after smoothing

  /// Grey value of the surface. A threshold at half height finds the true position of a blurred edge.
  double surface() const { return outside + height * (soft - outside); }
  double denser() const { return 0.5 * (soft + *dense); }
  double top() const { return dense.value_or(soft); }
};

struct Peak {
  double level;  // grey value
  double mass;   // fraction of all voxels, counted between the adjacent valleys
};
/// Peaks of the histogram that rise clearly above their valleys, from dark to bright.
std::vector<Peak> peaks_of(const Grid<float>& greys, double blur);

/// `smoothed`: `grey` after slight smoothing. Throws Error if no tissue is found.
Levels find_levels(const std::filesystem::path& file, const Grid<float>& grey, const Grid<float>& smoothed,
                   const ImportOptions& options, std::vector<std::string>& notes);

}  // namespace typodont::haptics::importing
