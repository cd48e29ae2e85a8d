// Measures the time of a servo tick deep in tissue, for the contact models that use triangle meshes.
#pragma once

#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont::haptics::bench {

/// Adds the rows. Burs of three shapes, or of all seven (`all_burs`), sink 1.5 mm into a block of dentin and widen the
/// hole on a growing circle.
void cavity_rows(const char* model, bool all_burs, bool quick, std::vector<BenchRow>& rows);

}  // namespace typodont::haptics::bench
