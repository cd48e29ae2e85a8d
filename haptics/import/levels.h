// Which greys are what: found in the histogram.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "haptics/import/grid.h"
#include "haptics/import/import.h"

namespace typodont::haptics::importing {

struct Levels {
  double outside = 0;           // of the surround
  double soft = 0;              // of the softer tissue (dentin, cancellous bone)
  std::optional<double> dense;  // of the denser (enamel, cortical bone), where there are two
  bool fixed_dense = false;     // the bound between the two was given, not found
  bool fixed_surround = false;  // layers on the tissue as bright as `outside` are its surround, however thin
  double height = 0.5;  // of the surface between the surround's grey and the tissue's; a half unless it was given
  std::optional<double> hounsfield;  // the grey of 0 Hounsfield units, where the greys are such
  double noise = 0;                  // standard deviation of the surround's greys
  double smoothed_noise = 0;         // … after smoothing

  /// At half height: where a blurred edge truly is.
  double surface() const { return outside + height * (soft - outside); }
  double denser() const { return 0.5 * (soft + *dense); }
  double top() const { return dense.value_or(soft); }
};

struct Peak {
  double level;  // grey
  double mass;   // share of all voxels between its valleys
};
/// Hills of the histogram that rise clearly out of their valleys, from dark to bright.
std::vector<Peak> peaks_of(const Grid<float>& greys, double blur);

/// `smoothed` is `grey` after a slight smoothing. Throws Error when there is no tissue to be found.
Levels find_levels(const std::filesystem::path& file, const Grid<float>& grey, const Grid<float>& smoothed,
                   const ImportOptions& options, std::vector<std::string>& notes);

}  // namespace typodont::haptics::importing
