// Measures how much power and computing time a live session needs: the electric power of the processor (W) on machines
// that can measure it, and the CPU time in core-seconds per minute on all machines.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "engine/contract/bench_row.h"

namespace typodont {

/// Values of the energy counters of all processor packages at one moment.
struct PackageEnergy {
  double counted = 0;  // J, sum of the energy counters of all processor packages
  double range = 0;    // J, sum of the counters' ranges; a counter starts again at zero at the end of its range
};

/// Reads the energy counters (RAPL) below `powercap`, which is /sys/class/powercap on Linux. No value: the machine has
/// no such counter, or this user may not read it.
std::optional<PackageEnergy> read_package_energy(const std::filesystem::path& powercap);
/// Returns the energy in J that was used between two readings. A counter may have started again at zero once.
double energy_between(const PackageEnergy& before, const PackageEnergy& after);

/// Adds rows for live sessions without a picture: with the hand at rest, and while the hand drills. `quick`: true for
/// shorter sessions.
void energy_rows(bool quick, std::vector<BenchRow>& rows);

}  // namespace typodont
