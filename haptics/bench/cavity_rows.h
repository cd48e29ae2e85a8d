// Measures the time of a servo tick deep inside tissue, for the contact models that use triangle meshes.
#pragma once

#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont::haptics::bench {

/// Adds the rows. A bur sinks 1.5 mm into a block of dentin and then widens the hole on a growing circle. One row
/// states by how much the removed volume differs from that of the model "offset". `all_burs`: true: burs of all seven
/// shapes; false: of three shapes.
void cavity_rows(const char* model, bool all_burs, bool quick, std::vector<BenchRow>& rows);

/// Adds rows of the same kind for a block with 1,000,000 instead of 53,000 vertices, and burs of three shapes.
void large_cavity_rows(const char* model, std::vector<BenchRow>& rows);

}  // namespace typodont::haptics::bench
