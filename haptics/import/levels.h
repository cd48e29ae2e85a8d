// Finds the grey values of the surroundings and of the tissues in the histogram of a scan.
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
  // grey value of the denser tissue (enamel, cortical bone); no value if there is only one tissue
  std::optional<double> dense;
  bool fixed_dense = false;  // true if the user gave the threshold between the two tissues
  // true: a thin layer on the tissue that is as bright as `outside` counts as surroundings (soft tissue on a bone)
  bool fixed_surround = false;
  // grey value above which a voxel belongs to a tooth. If a scan contains several bodies, the body with teeth is
  // imported, even if a body without teeth (a spine) is larger. No value: the largest body is imported.
  std::optional<double> tooth;
  // m³; a body counts as a body with teeth only if its voxels brighter than `tooth` have at least this volume together
  static constexpr double kLeastTeeth = 8e-9;
  // position of the surface threshold on a scale from the grey value `outside` (0) to the grey value `soft` (1)
  double height = 0.5;
  std::optional<double> hounsfield;  // grey value of 0 Hounsfield units; no value if it is unknown
  double noise = 0;                  // standard deviation of the grey values in the surroundings
  double smoothed_noise = 0;         // standard deviation of the grey values in the surroundings after smoothing

  /// Returns the grey value of the surface. At the true position of a blurred edge, the grey value is halfway between
  /// both sides.
  double surface() const { return outside + height * (soft - outside); }
  double denser() const { return 0.5 * (soft + *dense); }
  double top() const { return dense.value_or(soft); }
};

struct Peak {
  double level;  // grey value of the peak
  double mass;   // fraction of all voxels between the valleys on both sides of the peak
};
/// Returns the peaks of the histogram that rise clearly above their valleys, from dark to bright. `blur`: width of the
/// noise in grey values.
std::vector<Peak> peaks_of(const Grid<float>& greys, double blur);

/// Finds the grey values of the surroundings and of the tissues. `smoothed` contains the values of `grey` after slight
/// smoothing. Throws Error if no tissue is found.
Levels find_levels(const std::filesystem::path& file, const Grid<float>& grey, const Grid<float>& smoothed,
                   const ImportOptions& options, std::vector<std::string>& notes);

}  // namespace typodont::haptics::importing
