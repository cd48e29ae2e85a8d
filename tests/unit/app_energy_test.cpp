// The energy counters of the processor packages, from files like those of /sys/class/powercap.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "engine/app/bench/energy_rows.h"
#include "engine/base/temporary_folder.h"

namespace typodont {
namespace {

void write_zone(const std::filesystem::path& zone, const char* energy) {
  std::filesystem::create_directories(zone);
  std::ofstream(zone / "energy_uj") << energy << '\n';
  std::ofstream(zone / "max_energy_range_uj") << "262143328850\n";
}

TEST(PackageEnergy, IsTheSumOfThePackagesWithoutTheirParts) {
  const TemporaryFolder folder;
  write_zone(folder.path() / "intel-rapl:0", "1500000");
  write_zone(folder.path() / "intel-rapl:0:0", "700000");
  write_zone(folder.path() / "intel-rapl:1", "250000");
  const auto energy = read_package_energy(folder.path());
  ASSERT_TRUE(energy);
  EXPECT_DOUBLE_EQ(energy->counted, 1.75);
  EXPECT_DOUBLE_EQ(energy->range, 2 * 262143.32885);
}

TEST(PackageEnergy, ContinuesAfterACounterStartsAgainAtZero) {
  EXPECT_DOUBLE_EQ(energy_between({10, 100}, {25, 100}), 15);
  EXPECT_DOUBLE_EQ(energy_between({95, 100}, {5, 100}), 10);
}

TEST(PackageEnergy, IsUnknownWithoutReadableCounters) {
  const TemporaryFolder folder;
  EXPECT_FALSE(read_package_energy(folder.path()));
  EXPECT_FALSE(read_package_energy(folder.path() / "missing"));
  std::filesystem::create_directories(folder.path() / "intel-rapl:0");
  EXPECT_FALSE(read_package_energy(folder.path()));
}

}  // namespace
}  // namespace typodont
