// Time of a servo tick deep in tissue, for the contact models of triangle meshes.
#pragma once

#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont::haptics::bench {

/// Burs of three shapes sink 1.5 mm into a block of dentin and widen the hole on a growing circle.
void cavity_rows(const char* model, bool quick, std::vector<BenchRow>& rows);

}  // namespace typodont::haptics::bench
