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
  // true: the threshold between the softer and the denser tissue is already known, because the user gave it or because
  // the grey values are Hounsfield units plus a constant
  bool fixed_dense = false;
  // true: soft tissue that covers a bone as a thin layer counts as surroundings, because it is as bright as `outside`;
  // the air beyond the layer is darker
  bool fixed_surround = false;
  // Grey value above which a voxel belongs to a tooth. If a scan contains several bodies, the largest body with teeth
  // is imported, even if another body (a spine) is larger. If there is no value, the largest body is imported.
  std::optional<double> tooth;
  // m³; a body has teeth only if all its voxels brighter than `tooth` together have at least this volume
  static constexpr double kLeastTeeth = 8e-9;
  // threshold of the surface on a scale of grey values: 0 is the grey value `outside`, 1 is the grey value `soft`
  double height = 0.5;
  std::optional<double> hounsfield;  // grey value of 0 Hounsfield units; no value if it is unknown
  double noise = 0;                  // standard deviation of the grey values in the surroundings
  double smoothed_noise = 0;         // standard deviation of the grey values in the surroundings after smoothing

  /// Returns the grey value at the surface. The true position of a blurred edge is where the grey value is halfway
  /// between both sides, so `height` is 0.5 unless the user gives the threshold.
  double surface() const { return outside + height * (soft - outside); }
  double denser() const { return 0.5 * (soft + *dense); }
  double top() const { return dense.value_or(soft); }
};

struct Peak {
  double level;  // grey value of the peak
  double mass;   // fraction of all voxels between the valleys on both sides of the peak
};
/// Returns the peaks of the histogram that rise clearly above the valleys beside them, from dark to bright. `blur` is
/// the standard deviation of the noise in grey values.
std::vector<Peak> peaks_of(const Grid<float>& greys, double blur);

/// Finds the grey values of the surroundings and of the tissues. `smoothed` contains the values of `grey` after slight
/// smoothing. Throws Error if no tissue is found.
Levels find_levels(const std::filesystem::path& file, const Grid<float>& grey, const Grid<float>& smoothed,
                   const ImportOptions& options, std::vector<std::string>& notes);

}  // namespace typodont::haptics::importing
