// Estimates how much pulp lies in root canals that are narrower than the scan can show.
#pragma once

#include "haptics/dense_tissue.h"

namespace typodont::haptics::importing {

/// Returns the volume that the root canals of a tooth can have without being visible in its scan, m³. Any root without
/// pulp may contain such a canal along its whole length; in a slice across the tooth's longest axis, a root is a
/// connected area of dentin without enamel. So this is an upper limit for teeth with one canal per root. `diameter`:
/// widest canal that the scan does not show, m.
double unseen_canal_volume(const DenseTissue& tooth, double diameter);

}  // namespace typodont::haptics::importing
