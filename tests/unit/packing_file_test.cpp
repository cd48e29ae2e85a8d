// Tests packings in files: reading gives exactly what was written.
#include "engine/session/packing_file.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "engine/base/error.h"
#include "tests/support/folder.h"

namespace typodont::session {
namespace {

class PackingFile : public ::testing::Test {
 protected:
  void SetUp() override {
    for (int i = 0; i < 40; ++i) {
      packing_.center.push_back(dvec3(i, 2 * i, -i) * 1e-4);
      packing_.radius.push_back(1e-4 / (i + 1));
      packing_.tissue.push_back(i % 3 == 0 ? Tissue::kEnamel : Tissue::kDentin);
    }
    packing_.seed = 5, packing_.tissue_hash = 0xfedcba9876543210u, packing_.max_radius = 2e-4;
    packing_.max_hole = 1e-6, packing_.solid_volume[1] = 1e-9, packing_.solid_volume[2] = 3e-9;
  }
  std::filesystem::path path(const char* name) const { return folder_ / name; }
  TemporaryFolder own_;
  const std::filesystem::path folder_ = own_.path();
  SpherePacking packing_;
};

TEST_F(PackingFile, APackingIsReadBackBitForBit) {
  save_packing(path("p.h5"), packing_);
  const SpherePacking back = load_packing(path("p.h5"));
  EXPECT_EQ(back.center, packing_.center);
  EXPECT_EQ(back.radius, packing_.radius);
  EXPECT_EQ(back.tissue, packing_.tissue);
  EXPECT_EQ(back.seed, packing_.seed);
  EXPECT_EQ(back.tissue_hash, packing_.tissue_hash);
  EXPECT_EQ(back.max_radius, packing_.max_radius);
  EXPECT_EQ(back.max_hole, packing_.max_hole);
  EXPECT_EQ(back.solid_volume, packing_.solid_volume);
}

TEST_F(PackingFile, EqualPackingsAreEqualFiles) {
  save_packing(path("a.h5"), packing_);
  save_packing(path("b.h5"), packing_);
  EXPECT_EQ(test::read_text(path("a.h5")), test::read_text(path("b.h5")));
}

TEST_F(PackingFile, AByteChangedAnywhereInTheDataIsNoticed) {
  save_packing(path("p.h5"), packing_);
  const std::string good = test::read_text(path("p.h5"));
  const auto* first = reinterpret_cast<const char*>(packing_.center.data());
  const std::size_t at = good.find(std::string(first + sizeof(dvec3), sizeof(dvec3)));
  ASSERT_NE(at, std::string::npos);
  for (std::size_t i = at; i < at + 500; i += 7) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 1);
    std::ofstream(path("bad.h5"), std::ios::binary) << bad;
    EXPECT_THROW(load_packing(path("bad.h5")), Error) << i;
  }
}

TEST_F(PackingFile, AFileCutShortIsRefused) {
  save_packing(path("p.h5"), packing_);
  const std::string good = test::read_text(path("p.h5"));
  for (std::size_t size = 0; size < good.size(); size += 301) {
    std::ofstream(path("short.h5"), std::ios::binary) << good.substr(0, size);
    EXPECT_THROW(load_packing(path("short.h5")), Error) << size;
  }
}

TEST_F(PackingFile, ImpossibleSpheresAreRefused) {
  for (const auto& spoil : {+[](SpherePacking& p) { p.radius[3] = 0; }, +[](SpherePacking& p) { p.radius[3] = -1e-4; },
                            +[](SpherePacking& p) { p.tissue[3] = Tissue::kAir; },
                            +[](SpherePacking& p) { p.tissue[3] = static_cast<Tissue>(200); },
                            +[](SpherePacking& p) { p.center[3].y = std::numeric_limits<double>::quiet_NaN(); }}) {
    SpherePacking bad = packing_;
    spoil(bad);
    save_packing(path("bad.h5"), bad);
    EXPECT_THROW(load_packing(path("bad.h5")), Error);
  }
}

TEST_F(PackingFile, OtherFilesAreRefusedByName) {
  std::ofstream(path("text.h5")) << "hello";
  for (const auto& file : {path("text.h5"), path("missing.h5"), folder_}) {
    EXPECT_THAT(test::refusal([&] { (void)load_packing(file); }), testing::HasSubstr(file.string()));
  }
}

TEST_F(PackingFile, AnUnwritablePathIsAnErrorAndLeavesNoFile) {
  EXPECT_THROW(save_packing(folder_ / "no" / "p.h5", packing_), Error);
  EXPECT_THROW(save_packing(folder_, packing_), Error);
  EXPECT_TRUE(std::filesystem::is_empty(folder_));
}

}  // namespace
}  // namespace typodont::session
