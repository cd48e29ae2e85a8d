// Tests runtimes with any behaviour at any time: the program follows, violates no rule, and ends.
#include <gtest/gtest.h>

#include <random>

#include "engine/app/live/xr_stage.h"
#include "engine/base/error.h"
#include "engine/base/log.h"
#include "tests/support/default_colors.h"
#include "tests/support/stage.h"
#include "tests/support/tooth_mesh.h"
#include "tests/support/xr_fixture.h"

namespace typodont::test {
namespace {

struct Outcome {
  int frames = 0, drawn = 0;
  bool left = false;    // by the user
  bool asleep = false;  // never began
  std::string failure;  // lost
};

struct XrStates : testing::Test {
  XrFixture xr;
  display::DisplayRig rig;
  haptics::ServoSettings servo;

  void SetUp() override {
    rig.kind = display::DisplayKind::kHmd;
    rig.hmd.wait = 0.5;
    servo.materials = render::default_colors();
    servo.tool.shape = haptics::HeadShape::kSphere;
    servo.tool.diameter = 1.6e-3;
  }

  /// Runs a session of `frames` frames (or of as many turns if there are no frames). Then asks the session to end, and
  /// follows its states to the end.
  Outcome run(int frames) {
    Outcome out;
    display::RuntimeGate gate;
    try {
      Scene scene;
      scene.servo = servo;
      World world(scene);
      XrStage stage(rig, servo, {0, 0, 4e-3}, gate, {render::kQualityLadder[4]});
      display::Hmd& hmd = stage.hmd();
      stage.show(std::vector{ball(1, {0, 0, 0}, 4e-3f, Tissue::kEnamel, 12)}, {0, 0, 0});
      hmd.wake();
      bool asked = false;
      int idle = 0;
      out.left = true;
      while (hmd.poll()) {
        const bool enough = out.frames >= frames || idle > 200;
        if (enough && !asked) {
          asked = true;
          out.left = false;
          hmd.request_exit();
          continue;
        }
        if (idle > 400) throw RunFailure("the session did not end");
        if (!hmd.running()) {
          ++idle;
          continue;
        }
        idle = 0;
        const display::HmdFrame frame = hmd.wait();
        stage.draw(frame, world);
        for (int hand = 0; hand < 2 && frame.focused; ++hand) hmd.vibrate(hand, {out.frames % 3 ? 0.5 : 0.0, 100});
        ++out.frames;
        out.drawn += frame.draw;
        hmd.timings();
      }
    } catch (const Error& e) {
      out.asleep = true;
      out.failure = e.what();
    } catch (const RunFailure& e) {
      out.failure = e.what();
    }
    return out;
  }
};

const std::string kSmall = R"("view_size": [48, 32], "mask": [[-2, -2], [-0.7, -2], [-0.7, 2]],
  "hands": {"right": [{"frame": 0, "p": [0.1, 1.2, -0.3]}], "left": [{"frame": 0, "p": [-0.1, 1.2, -0.3]}]})";

TEST_F(XrStates, AThousandFramesWithRandomChangesOfStateBreakNoRule) {
  std::mt19937 random(11);
  const std::vector<std::string> kinds{R"("event": "unfocus")",
                                       R"("event": "focus")",
                                       R"("event": "hide")",
                                       R"("event": "show")",
                                       R"("event": "focus")",
                                       R"("event": "stop", "count": 3)",
                                       R"("event": "mask")",
                                       R"("event": "profile")",
                                       R"("event": "events_lost")",
                                       R"("event": "unknown")",
                                       R"("event": "no_render", "count": 5)",
                                       R"("event": "unlocatable", "count": 4)",
                                       R"("event": "refresh")",
                                       R"("event": "recenter", "p": [0.1, 0, 0.2], "q": [0.9, 0, 0.43589, 0])",
                                       R"("event": "recenter", "pose_valid": false)"};
  std::string events;
  for (int frame = 5; frame < 1000; frame += 1 + static_cast<int>(random() % 12))
    events += fmt::format("{}{{\"frame\": {}, {}}}", events.empty() ? "" : ", ", frame, kinds[random() % kinds.size()]);
  xr.script(kSmall + ", \"events\": [" + events + "]");
  const Outcome out = run(1000);
  EXPECT_EQ(out.failure, "");
  EXPECT_EQ(out.frames, 1000);
  EXPECT_GT(out.drawn, 100);
  EXPECT_LT(out.drawn, 1000);
  EXPECT_GT(xr.count("state STOPPING"), 3);
  EXPECT_EQ(xr.violations(), "");
}

/// One case sends one event when the runtime enters one state. Afterwards the session must continue, end or be lost, as
/// the case states.
struct EventCase {
  const char* event;
  enum { kGoesOn, kLeft, kLost } end;
};
constexpr EventCase kEvents[] = {
    {R"("event": "unfocus")", EventCase::kGoesOn},
    {R"("event": "hide")", EventCase::kGoesOn},
    {R"("event": "show")", EventCase::kGoesOn},
    {R"("event": "focus")", EventCase::kGoesOn},
    {R"("event": "stop", "count": 3)", EventCase::kGoesOn},
    {R"("event": "recenter", "p": [0, 0, 1])", EventCase::kGoesOn},
    {R"("event": "mask")", EventCase::kGoesOn},
    {R"("event": "profile")", EventCase::kGoesOn},
    {R"("event": "events_lost")", EventCase::kGoesOn},
    {R"("event": "unknown")", EventCase::kGoesOn},
    {R"("event": "refresh")", EventCase::kGoesOn},
    {R"("event": "no_render", "count": 3)", EventCase::kGoesOn},
    {R"("event": "unlocatable", "count": 3)", EventCase::kGoesOn},
    {R"("event": "exit")", EventCase::kLeft},
    {R"("event": "loss_pending")", EventCase::kLost},
    {R"("event": "session_lost")", EventCase::kLost},
    {R"("event": "instance_loss_pending")", EventCase::kLost},
    {R"("event": "instance_lost")", EventCase::kLost},
};

class XrEventAtState : public XrStates, public testing::WithParamInterface<const char*> {};

TEST_P(XrEventAtState, EveryEventIsHandledInEveryState) {
  for (const EventCase& c : kEvents) {
    const std::string state = GetParam();
    SCOPED_TRACE(fmt::format("{} in {}", c.event, state));
    // The state STOPPING occurs only if something stops the session. So the runtime stops it at the eighth frame.
    const std::string stop = state == "STOPPING" ? R"({"frame": 8, "event": "stop", "count": 3}, )" : "";
    xr.script(fmt::format("{}, \"events\": [{}{{\"state\": \"{}\", {}}}]", kSmall, stop, state, c.event));
    const Outcome out = run(14);
    EXPECT_EQ(xr.violations(), "");
    std::string name = std::string(c.event).substr(10);  // after "event": "
    name.erase(name.find('"'));
    EXPECT_EQ(xr.count("event " + name + " in " + state), 1);
    switch (c.end) {
      case EventCase::kGoesOn:
        EXPECT_EQ(out.failure, "");
        EXPECT_EQ(out.frames, 14);
        break;
      case EventCase::kLeft:
        EXPECT_TRUE(out.left || out.asleep) << out.frames;
        EXPECT_LT(out.frames, 14);
        break;
      case EventCase::kLost:
        EXPECT_NE(out.failure, "");
        EXPECT_LT(out.frames, 14);
        break;
    }
  }
}
INSTANTIATE_TEST_SUITE_P(States, XrEventAtState,
                         testing::Values("IDLE", "READY", "SYNCHRONIZED", "VISIBLE", "FOCUSED", "STOPPING"),
                         [](const auto& state) { return std::string(state.param); });

TEST_F(XrStates, AFailureOfAnyCallEndsTheSessionProperly) {
  for (const char* call : {"xrCreateSession",
                           "xrCreateReferenceSpace",
                           "xrEnumerateSwapchainFormats",
                           "xrCreateSwapchain",
                           "xrEnumerateSwapchainImages",
                           "xrCreateActionSet",
                           "xrSuggestInteractionProfileBindings",
                           "xrAttachSessionActionSets",
                           "xrBeginSession",
                           "xrPollEvent",
                           "xrWaitFrame",
                           "xrBeginFrame",
                           "xrLocateSpace",
                           "xrLocateViews",
                           "xrSyncActions",
                           "xrGetActionStateFloat",
                           "xrAcquireSwapchainImage",
                           "xrWaitSwapchainImage",
                           "xrReleaseSwapchainImage",
                           "xrEndFrame"}) {
    SCOPED_TRACE(call);
    // Calls of the setup fail during the setup. Calls of a frame fail in the seventh frame.
    const bool early = std::string(call).starts_with("xrCreate") || std::string(call).starts_with("xrEnum") ||
                       std::string(call).starts_with("xrSuggest") || std::string(call).starts_with("xrAttach") ||
                       std::string(call) == "xrBeginSession";
    xr.script(fmt::format("{}, \"events\": [{{{}, \"event\": \"fail\", \"call\": \"{}\"}}]", kSmall,
                          early ? "\"state\": \"CREATED\"" : "\"frame\": 7", call));
    const Outcome out = run(20);
    EXPECT_NE(out.failure.find(call), std::string::npos) << out.failure;
    EXPECT_LT(out.frames, 20);
    EXPECT_EQ(xr.violations(), "");
  }
}

TEST_F(XrStates, WorksWithoutTheOptionalExtensions) {
  xr.script(kSmall + R"(, "extensions": ["XR_KHR_vulkan_enable2"], "spaces": ["local", "view"], "images": 1,
                     "formats": ["D16_UNORM", "B8G8R8A8_SRGB"])");
  rig.hmd.stage = true;
  rig.hmd.passthrough = true;
  const Outcome out = run(30);
  EXPECT_EQ(out.failure, "");
  EXPECT_EQ(xr.violations(), "");
  EXPECT_EQ(xr.count("+depth"), 0);
  EXPECT_GT(xr.count("projection opaque"), 10);
}

struct XrPlaces : XrStates {
  static constexpr dvec3 kWork{0.01, 0.02, 0.03};

  /// Every frame of a session of so many.
  std::vector<display::HmdFrame> frames(int count) {
    std::vector<display::HmdFrame> all;
    display::RuntimeGate gate;
    Scene scene;
    scene.servo = servo;
    World world(scene);
    XrStage stage(rig, servo, kWork, gate, {render::kQualityLadder[4]});
    stage.hmd().wake();
    while (static_cast<int>(all.size()) < count && stage.hmd().poll()) {
      all.push_back(stage.hmd().wait());
      stage.draw(all.back(), world);
    }
    EXPECT_EQ(xr.violations(), "");
    return all;
  }
  static dvec3 between(const display::HmdFrame& f) { return 0.5 * (f.eyes[0].position + f.eyes[1].position); }
  /// Returns the position of the work as the eyes see it: to the right, up, and away from the user, in metres of the
  /// room.
  dvec3 seen_work(const display::HmdFrame& f) const {
    return rig.hmd.magnify * (glm::conjugate(f.X_WH.R) * (kWork - between(f)));
  }
};

TEST_F(XrPlaces, TheWorkIsPlacedBeforeTheUserAtTheStartAndByTheButton) {
  rig.hmd.magnify = 4;
  // After frame 12 the user sits at another place and has turned by 90 degrees to the left. At frame 20 the user
  // presses the button.
  xr.script(R"("view_size": [48, 32], "profile": "/interaction_profiles/htc/vive_controller",
    "head": [{"frame": 0, "p": [0.3, 1.4, 0.2]}, {"frame": 11, "p": [0.3, 1.4, 0.2]},
             {"frame": 12, "p": [1, 1.2, -2], "q": [0.70710678, 0, 0.70710678, 0]}],
    "hands": {"left": [{"frame": 0}, {"frame": 20, "buttons": ["menu/click"]}, {"frame": 22}]})");
  const auto all = frames(30);
  ASSERT_EQ(all.size(), 30u);
  const dvec3 wanted(0, -rig.hmd.below, -rig.hmd.distance);
  EXPECT_LT(glm::length(seen_work(all[9]) - wanted), 1e-5);
  EXPECT_GT(glm::length(seen_work(all[16]) - wanted), 1.0);
  EXPECT_LT(glm::length(seen_work(all[28]) - wanted), 1e-5);
  // The user sits at negative y of frame W and looks along +y. The user's head is upright along z.
  EXPECT_LT(glm::length(all[28].X_WH.rotate({0, 0, -1}) - dvec3(0, 1, 0)), 1e-5);
  EXPECT_LT(glm::length(all[28].X_WH.rotate({0, 1, 0}) - dvec3(0, 0, 1)), 1e-5);
}

TEST_F(XrPlaces, RecentringDoesNotMoveAMeasuredSpace) {
  rig.hmd.stage = false;
  rig.hmd.X_WD = Pose{{0.1, 0.2, 0.3}, glm::normalize(dquat(1, 0.2, 0, 0))};
  const std::string pressed = R"("hands": {"right": [{"frame": 0}, {"frame": 14, "buttons": ["menu/click"]}]})";
  xr.script(R"("view_size": [48, 32], "profile": "/interaction_profiles/htc/vive_controller", )" + pressed +
            R"(, "events": [{"frame": 10, "event": "recenter", "p": [0.4, 0, -1], "q": [0.8, 0, 0.6, 0]}])");
  const auto all = frames(24);
  EXPECT_LT(glm::length(between(all[8]) - between(all[20])), 1e-5);
  EXPECT_GT(std::abs(glm::dot(all[8].X_WH.R, all[20].X_WH.R)), 1 - 1e-9);
}

TEST_F(XrPlaces, TheToolsHeadIsAtTheControllersTipWithItsShankTowardsTheHand) {
  rig.hmd.X_WD = Pose{};
  xr.script(R"("view_size": [48, 32], "profile": "/interaction_profiles/valve/index_controller",
    "hands": {"right": [{"frame": 0, "p": [0.1, 1, -0.3], "q": [0.70710678, -0.70710678, 0, 0], "trigger": 0.6}]})");
  const auto all = frames(12);
  const display::HmdHand& hand = all.back().hands[1];
  ASSERT_TRUE(hand.tracked);
  EXPECT_NEAR(hand.pedal, 0.6, 1e-6);
  EXPECT_LT(glm::length(hand.X_WT.p - dvec3(0.1, 1 - 0.06, -0.3)), 1e-6);  // it points down
  EXPECT_LT(glm::length(hand.X_WT.rotate({0, 0, 1}) - dvec3(0, 1, 0)), 1e-6);
  EXPECT_FALSE(all.back().hands[0].tracked);
}

TEST_F(XrStates, NothingIsShownBeforeTheHeadIsTracked) {
  xr.script(kSmall + R"(, "events": [{"frame": 0, "event": "unlocatable", "count": 12}])");
  const Outcome out = run(30);
  EXPECT_EQ(out.failure, "");
  EXPECT_EQ(xr.violations(), "");
  const auto frames = xr.lines("frame ");
  for (const std::string& line : frames) {
    int number = 0;
    if (std::sscanf(line.c_str(), "frame %d ", &number) != 1) continue;
    if (number < 12) {
      EXPECT_NE(line.find("empty"), std::string::npos) << line;
    }
  }
  EXPECT_GT(out.drawn, 10);
}

}  // namespace
}  // namespace typodont::test
