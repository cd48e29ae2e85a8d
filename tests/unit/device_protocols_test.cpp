#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "haptics/devices/arm_protocol.h"
#include "haptics/devices/haply.h"
#include "haptics/devices/json_scan.h"
#include "haptics/devices/pedal.h"
#include "haptics/devices/spacemouse.h"

namespace typodont::haptics {
namespace {

using Bytes = std::vector<std::uint8_t>;
std::span<const std::uint8_t> as_bytes(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

TEST(ArmProtocol, ReportsAreLittleEndianSixteenBit) {
  const auto v1 = parse_hid(ArmProtocol::kHidV1, Bytes{0x01, 0x00, 0xff, 0xff, 0x00, 0x80, 9, 9});
  ASSERT_TRUE(v1);
  EXPECT_EQ(v1->encoders[0], 1);
  EXPECT_EQ(v1->encoders[1], -1);
  EXPECT_EQ(v1->encoders[2], -32768);
  const auto v2 = parse_hid(ArmProtocol::kHidV2, Bytes{1, 0, 2, 0, 3, 0, 4, 0, 5, 0, 6, 0, 1, 0});
  ASSERT_TRUE(v2);
  EXPECT_EQ(v2->encoders[5], 6);
  EXPECT_TRUE(v2->button);
}

TEST(ArmProtocol, MergedReportsGiveTheNewestAndShortOnesNothing) {
  Bytes merged(16, 0);
  merged[8] = 7;
  const auto report = parse_hid(ArmProtocol::kHidV1, merged);
  ASSERT_TRUE(report);
  EXPECT_EQ(report->encoders[0], 7);
  for (std::size_t n : {0u, 1u, 7u, 9u, 15u}) EXPECT_FALSE(parse_hid(ArmProtocol::kHidV1, Bytes(n, 1))) << n;
}

TEST(ArmProtocol, CommandsAreAsLongAsEachBoardExpectsAndStartWithNoReportId) {
  const auto v1 = encode(ArmProtocol::kHidV1, {1.5, -2, 0.0009});
  EXPECT_EQ(Bytes(v1.span().begin(), v1.span().end()), (Bytes{0, 0xdc, 0x05, 0x30, 0xf8, 0, 0, 0, 0}));
  EXPECT_EQ(encode(ArmProtocol::kHidV2, dvec3(0)).size, 15u);
  EXPECT_EQ(encode(ArmProtocol::kRawHid, dvec3(0)).size, 65u);
  const auto text = encode(ArmProtocol::kText, {0.25, -3, 0});
  EXPECT_EQ(std::string(text.span().begin(), text.span().end()), "[250,-3000,0]\n");
}

TEST(ArmProtocol, CurrentsThatAreNoNumbersAreZeroAndHugeOnesSaturate) {
  const auto text = encode(ArmProtocol::kText, {std::nan(""), INFINITY, 1e9});
  EXPECT_EQ(std::string(text.span().begin(), text.span().end()), "[0,0,32767]\n");
}

TEST(ArmProtocol, TextLinesAreReadExactlyOrNotAtAll) {
  const auto report = parse_text("[1,8312,-10366,19764,0,30,-5,0]\r");
  ASSERT_TRUE(report);
  EXPECT_EQ(report->model, 1);
  EXPECT_EQ(report->encoders[1], -10366);
  EXPECT_EQ(report->encoders[5], -5);
  for (const char* bad : {"", "[", "[]", "[1,2,3]", "[1,2,3,4,5,6,7,8,9]", "[9,0,0,0,0,0,0,0]", "[1,2,3,4,5,6,7,x]",
                          "1,2,3,4,5,6,7,8", "[1,2,3,4,5,6,7,99999999999]", "[1,2,,4,5,6,7,8]"}) {
    EXPECT_FALSE(parse_text(bad)) << bad;
  }
}

TEST(LineAssembler, PutsSplitLinesTogetherAndKeepsTheNewest) {
  LineAssembler lines;
  lines.add(as_bytes("[1,2"));
  EXPECT_FALSE(lines.take());
  lines.add(as_bytes(",3]\n[4]\n[5"));
  EXPECT_EQ(lines.take(), "[4]");
  EXPECT_EQ(lines.skipped(), 1u);
  EXPECT_FALSE(lines.take());
}

TEST(LineAssembler, DropsOverlongRubbishAndRecovers) {
  LineAssembler lines;
  lines.add(as_bytes(std::string(1000, 'x')));
  lines.add(as_bytes("\n[7]\n"));
  EXPECT_EQ(lines.take(), "[7]");
}

TEST(SpaceMouse, OldAndNewReportsAreDistinguishedByLength) {
  SpaceMouseState state;
  EXPECT_TRUE(parse_spacemouse(Bytes{1, 0x5e, 0x01, 0, 0, 0xa2, 0xfe}, state));  // 350, 0, -350
  EXPECT_EQ(state.push, dvec3(1, 0, -1));
  EXPECT_EQ(state.twist, dvec3(0));
  EXPECT_TRUE(parse_spacemouse(Bytes{1, 0, 0, 0xaf, 0, 0, 0, 0x5e, 0x01, 0, 0, 0, 0}, state));
  EXPECT_EQ(state.push, dvec3(0, 0.5, 0));
  EXPECT_EQ(state.twist, dvec3(1, 0, 0));
  EXPECT_TRUE(parse_spacemouse(Bytes{2, 0, 0, 0, 0, 0xaf, 0}, state));
  EXPECT_EQ(state.twist, dvec3(0, 0, 0.5));
  EXPECT_TRUE(parse_spacemouse(Bytes{3, 2, 0, 0, 0}, state));
  EXPECT_EQ(state.buttons, 2u);
  EXPECT_FALSE(parse_spacemouse(Bytes{1, 0, 0}, state));
  EXPECT_FALSE(parse_spacemouse(Bytes{23, 0, 0, 0, 0, 0, 0}, state));
}

TEST(SpaceMouse, OnlyModelsWithSixDegreesOfFreedomAreAccepted) {
  EXPECT_TRUE(is_spacemouse(0x046d, 0xc626));
  EXPECT_TRUE(is_spacemouse(0x256f, 0xc652));
  EXPECT_FALSE(is_spacemouse(0x256f, 0xc650));
  EXPECT_FALSE(is_spacemouse(0x046d, 0xc077));  // an ordinary mouse
}

/// HID descriptor with report number 3: two buttons, then a 12-bit accelerator and a 12-bit brake.
const Bytes kRheostat{0x05, 0x01, 0x09, 0x04, 0xa1, 0x01, 0x85, 0x03, 0x05, 0x09, 0x19, 0x01, 0x29, 0x02, 0x15, 0x00,
                      0x25, 0x01, 0x75, 0x01, 0x95, 0x02, 0x81, 0x02, 0x75, 0x06, 0x95, 0x01, 0x81, 0x03, 0x05, 0x02,
                      0x09, 0xc4, 0x09, 0xc5, 0x15, 0x00, 0x26, 0xff, 0x0f, 0x75, 0x0c, 0x95, 0x02, 0x81, 0x02, 0xc0};

TEST(HidDescriptor, FindsAxesBehindPaddingAndReportIds) {
  const auto fields = parse_descriptor(kRheostat);
  ASSERT_EQ(fields.size(), 4u);
  EXPECT_EQ(fields[0].usage, 0x090001u);
  EXPECT_EQ(fields[1].usage, 0x090002u);
  EXPECT_EQ(fields[2].usage, 0x0200c4u);
  EXPECT_EQ(fields[2].bit, 8u);
  EXPECT_EQ(fields[3].bit, 20u);
  EXPECT_EQ(fields[3].maximum, 4095);
  const Bytes report{3, 1, 0x34, 0x12, 0x56};  // accelerator 0x234, brake 0x561
  EXPECT_EQ(field_value(fields[2], report), 0x234);
  EXPECT_EQ(field_value(fields[3], report), 0x561);
  EXPECT_FALSE(field_value(fields[3], Bytes{3, 1, 0x34}));
  EXPECT_FALSE(field_value(fields[3], Bytes{4, 1, 0x34, 0x12, 0x56}));
}

TEST(HidDescriptor, SignedAxesKeepTheirSign) {
  const auto fields =
      parse_descriptor(Bytes{0x05, 0x01, 0x09, 0x32, 0x15, 0x81, 0x25, 0x7f, 0x75, 0x08, 0x95, 0x01, 0x81, 0x02});
  ASSERT_EQ(fields.size(), 1u);
  EXPECT_EQ(fields[0].minimum, -127);
  EXPECT_EQ(field_value(fields[0], Bytes{0x81}), -127);
}

TEST(Pedal, ARheostatRunsFromZeroToOneBetweenItsDeadBands) {
  const auto kind = pedal_kind(0x1234, 0x9999, kRheostat);
  ASSERT_TRUE(kind);
  EXPECT_EQ(kind->type, PedalKind::Type::kAxis);
  const auto at = [&](int value) {
    const Bytes report{3, 0, static_cast<std::uint8_t>(value & 0xff), static_cast<std::uint8_t>(value >> 8), 0};
    return pedal_value(*kind, report).value();
  };
  EXPECT_EQ(at(0), 0);
  EXPECT_EQ(at(150), 0);  // inside the dead band
  EXPECT_NEAR(at(2048), 0.5, 1e-3);
  EXPECT_EQ(at(4000), 1);
  for (int v = 0; v < 4095; ++v) ASSERT_LE(at(v), at(v + 1));
}

TEST(Pedal, SwitchesAreKnownByTheirIds) {
  const auto keyboard = pedal_kind(0x0c45, 0x7403, {});
  ASSERT_TRUE(keyboard);
  EXPECT_EQ(pedal_value(*keyboard, Bytes{0, 0, 5, 0, 0, 0, 0, 0}), 1);
  EXPECT_EQ(pedal_value(*keyboard, Bytes{0, 0, 0, 0, 0, 0, 0, 0}), 0);
  const auto infinity = pedal_kind(0x05f3, 0x00ff, {});
  ASSERT_TRUE(infinity);
  EXPECT_EQ(pedal_value(*infinity, Bytes{2, 0}), 1);
  EXPECT_EQ(pedal_value(*infinity, Bytes{0, 0}), 0);
  EXPECT_FALSE(pedal_value(*infinity, Bytes{2}));
  EXPECT_FALSE(pedal_kind(0x046d, 0xc077, {}));
}

TEST(Pedal, AJoystickWithManyAxesIsNoPedal) {
  EXPECT_FALSE(pedal_kind(1, 2, Bytes{0x05, 0x01, 0x09, 0x30, 0x09, 0x31, 0x09, 0x32, 0x09, 0x35, 0x15,
                                      0x00, 0x26, 0xff, 0x00, 0x75, 0x08, 0x95, 0x04, 0x81, 0x02}));
}

TEST(JsonText, FindsValuesAfterStringsWithBrackets) {
  const JsonText json(R"({"a":"}{\"[","b" : [ {"c": -1.5e3 , "d":{}} , 2 ],"e":true})");
  EXPECT_EQ(json.get("b")->first()->get("c")->number(), -1500);
  EXPECT_TRUE(json.get("e")->is("true"));
  EXPECT_FALSE(json.get("f"));
  EXPECT_FALSE(JsonText("{\"a\":").get("a"));
  EXPECT_FALSE(JsonText("nan").number());
}

TEST(Haply, ReadsTheServicesStateAndRefusesOtherMessages) {
  const auto state = parse_haply(
      R"({"inverse3":[{"device_id":"04F5","state":{"cursor_velocity":{"x":0,"y":0,"z":0},"cursor_position":{"x":0.1,"y":-0.2,"z":0.3}}}],)"
      R"("wireless_verse_grip":[{"device_id":"1","state":{"orientation":{"w":0,"x":0,"y":0,"z":1},"buttons":{"a":true,"b":false}}}]})");
  ASSERT_TRUE(state);
  EXPECT_STREQ(state->id.data(), "04F5");
  EXPECT_EQ(state->position, dvec3(0.1, -0.2, 0.3));
  EXPECT_EQ(state->orientation, dquat(0, 0, 0, 1));
  EXPECT_TRUE(state->button);
  EXPECT_FALSE(parse_haply("{}"));
  EXPECT_FALSE(parse_haply(R"({"inverse3":[{"device_id":"a","state":{"cursor_position":{"x":0.1,"y":null,"z":0}}}]})"));
  EXPECT_FALSE(parse_haply(R"({"inverse3":[{"device_id":"a\"b","state":{"cursor_position":{"x":0,"y":0,"z":0}}}]})"));
}

}  // namespace
}  // namespace typodont::haptics
