#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>
#include <iterator>

#include "engine/session/format/columns.h"
#include "engine/session/ticks_csv.h"
#include "tests/support/session_fixture.h"

namespace typodont::session {
namespace {

using namespace test;
using testing::HasSubstr;
using TicksCsv = FolderTest;

void write_csv(const std::filesystem::path& file, std::span<const ServoTick> ticks) {
  TicksCsvWriter writer(file);
  writer.append(ticks);
  writer.finish();
}

TEST_F(TicksCsv, HasTheDocumentedColumnsInOrderAndNumbersAsTheShortestTextInPeoplesUnits) {
  ServoTick t;
  t.t = 1'001'000'000;
  t.X_WT.p = {1e-3, -2.5e-4, -0.0};
  t.f_T_W = {0.1, 1.0 / 3.0, -2};
  t.tissue = Tissue::kCorticalBone;
  t.removed[1] = 1e-9;
  t.cpu_time = 1500;
  t.faults = bits(Fault::kOverrun);
  t.tool = 2;
  t.pedal = 0.5;
  t.f_model_W = {0.25, 0, -1};
  t.wear = 0.5;
  write_csv(folder / "t.csv", {&t, 1});
  EXPECT_EQ(
      read_text(folder / "t.csv"),
      "t_s,hand_x_mm,hand_y_mm,hand_z_mm,tool_x_mm,tool_y_mm,tool_z_mm,force_x_N,force_y_N,force_z_N,torque_x_Nmm,"
      "torque_y_Nmm,torque_z_Nmm,depth_mm,normal_x,normal_y,normal_z,contact_area_mm2,removed_mm3,removed_enamel_mm3,"
      "removed_dentin_mm3,removed_caries_mm3,removed_pulp_mm3,removed_cortical_bone_mm3,removed_cancellous_bone_mm3,"
      "removed_gingiva_mm3,removed_amalgam_mm3,removed_composite_mm3,tissue,spindle_krpm,energy_mJ,tick_us,faults,"
      "pedal,tool,model_force_x_N,model_force_y_N,model_force_z_N,level,wear\n"
      "1.001,1,-0.25,0,0,0,0,0.1,0.3333333333333333,-2,0,0,0,0,0,0,0,0,1,1,0,0,0,0,0,0,0,0,cortical_bone,0,0,1.5,256,"
      "0.5,2,0.25,0,-1,0,0.5\n");
}

TEST_F(TicksCsv, ReadsBackWhatItWrote) {
  const auto ticks = random_ticks(500, 21);
  write_csv(folder / "t.csv", ticks);
  const auto back = read_ticks_csv(folder / "t.csv");
  ASSERT_EQ(back.size(), ticks.size());
  for (std::size_t i = 0; i < ticks.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_LE(ulps(back[i].X_WT.p[k], ticks[i].X_WT.p[k]), 1);
      EXPECT_EQ(back[i].f_T_W[k], ticks[i].f_T_W[k]);
      EXPECT_EQ(back[i].n_C_W[k], ticks[i].n_C_W[k]);
    }
    EXPECT_EQ(back[i].t, ticks[i].t);
    EXPECT_EQ(back[i].cpu_time, ticks[i].cpu_time);
    EXPECT_EQ(back[i].tissue, ticks[i].tissue);
    EXPECT_EQ(back[i].faults, ticks[i].faults);
    EXPECT_EQ(back[i].pedal, ticks[i].pedal);
    EXPECT_LE(ulps(back[i].removed[3], ticks[i].removed[3]), 1);
  }
  // Writing these ticks again gives the same numbers, to a unit in the last place. So the file is stable.
  write_csv(folder / "again.csv", back);
  write_csv(folder / "third.csv", read_ticks_csv(folder / "again.csv"));
  EXPECT_EQ(read_text(folder / "again.csv").size(), read_text(folder / "third.csv").size());
}

TEST_F(TicksCsv, BadFilesAreNamedByLineAndColumn) {
  const auto ticks = random_ticks(3, 22);
  write_csv(folder / "good.csv", ticks);
  const std::string good = read_text(folder / "good.csv");
  const auto bad = [&](const std::string& text) {
    std::ofstream(folder / "bad.csv") << text;
    return refusal([&] { read_ticks_csv(folder / "bad.csv"); });
  };
  EXPECT_THAT(bad(""), HasSubstr("bad.csv: found an empty file"));
  EXPECT_THAT(bad("t_s,hand_x_mm\n0,1\n"), HasSubstr("line 1: found no column \"hand_y_mm\""));
  EXPECT_EQ(read_ticks_csv(folder / "bad.csv", {"t_s", "hand_x_mm"}).size(), 1u);
  EXPECT_THAT(refusal([&] {
                read_ticks_csv(folder / "bad.csv", {"t_s", "force_x_N"});
              }),
              HasSubstr("line 1: found no column \"force_x_N\", expected the columns t_s,force_x_N"));
  EXPECT_THAT(bad(std::string("chalk,").append(good)), HasSubstr("line 1: found column \"chalk\""));
  EXPECT_THAT(bad(std::string("t_s,").append(good)), HasSubstr("line 1: found column \"t_s\" twice"));
  EXPECT_THAT(bad(good + "1,2\n"), HasSubstr("line 5: found 2 cells"));
  std::string text = good;
  text[text.find('\n') + 1] = 'x';
  EXPECT_THAT(bad(text), HasSubstr("line 2, column t_s"));
  text = good;
  const std::string tissue(name_of(ticks[0].tissue));
  text.replace(text.find(fmt::format(",{},", tissue), text.find('\n')) + 1, tissue.size(), "chalk");
  EXPECT_THAT(bad(text), HasSubstr("line 2, column tissue: found \"chalk\", expected the name of a tissue"));
  EXPECT_THAT(refusal([&] { read_ticks_csv(folder / "none.csv"); }), HasSubstr("No such file"));
}

TEST_F(TicksCsv, AnAbandonedTableLeavesNoFileAndAnUnwritablePathIsAnError) {
  { TicksCsvWriter(folder / "t.csv").append(random_ticks(5000, 23)); }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  EXPECT_THAT(refusal([] { TicksCsvWriter w("/nowhere/t.csv"); }), HasSubstr("/nowhere/t.csv"));
}

TEST(SessionFormat, TheDocumentNamesEveryColumn) {
  const std::string document = read_text("docs/session_format.md");
  const auto expect_named = [&](const auto& columns) {
    for (const auto& column : columns) EXPECT_THAT(document, HasSubstr(fmt::format("`{}`", column.name)));
  };
  expect_named(tick_columns());
  expect_named(cut_columns());
  expect_named(patch_columns());
}

TEST(SessionFormat, EveryFaultHasItsOwnNameAndBit) {
  std::uint32_t all = 0;
  for (const FaultName& fault : fault_names()) {
    EXPECT_EQ(all & bits(fault.fault), 0u) << fault.name;
    all |= bits(fault.fault);
  }
  EXPECT_EQ(all, (bits(Fault::kHeld) << 1) - 1) << "a fault without a name";
}

}  // namespace
}  // namespace typodont::session
