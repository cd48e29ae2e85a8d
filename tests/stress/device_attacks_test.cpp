// Tests attacks through a device while its motors press against a hand, in simulated time. The device's service or
// board is emulated; the safety layer is active, and the servo is in contact with tissue. Each attack begins when the
// hand feels a force. Afterwards the force must be zero, or the contact must continue as without the attack.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <random>
#include <string>

#include "engine/base/units.h"
#include "engine/contract/contact.h"
#include "haptics/devices/haply.h"
#include "haptics/devices/safe_device.h"
#include "haptics/devices/woodenhaptics.h"
#include "haptics/lockstep.h"
#include "haptics/solid.h"
#include "tests/support/campaign.h"
#include "tests/support/emulation/emulated_arm.h"
#include "tests/support/emulation/haply_service.h"
#include "tests/support/emulation/sim_time.h"

namespace typodont::haptics {
namespace {

using namespace literals;
using test::EmulatedArm;
using test::HaplyService;
using test::SimTime;

enum class Attack {
  kNone,
  kPings,        // a flood of pings between the states
  kPingsAlone,   // and no state any more
  kUnasked,      // states or reports that nobody requested, twenty times as many as usual; their content is true
  kRubbish,      // the same, of random bytes
  kSilence,      // nothing comes any more
  kClosed,       // the service says goodbye
  kGone,         // unplugged; the connection breaks
  kNotANumber,   // one state of such numbers
  kLeap,         // one state from somewhere else
  kPieces,       // states come in a hundred pieces each
  kStalledServo  // this process stands still for a while
};

/// A device in the hand of a user who presses into a wall and leaves it, five times per second.
class Rig {
 public:
  explicit Rig(SimTime& time) : time_(time) {}
  virtual ~Rig() = default;
  virtual std::unique_ptr<HapticDevice> open() = 0;
  virtual void attack(Attack attack) = 0;
  virtual dvec3 force() const = 0;    // N, of the motors on the hand
  virtual dvec3 at_wall() const = 0;  // m, the deepest point of the hand's way
  virtual int pongs() const { return 0; }

 protected:
  /// Returns 0 where the hand turns outside the tissue, and 2 where it turns inside. SimTime begins at 1 s. At first
  /// the hand rests, because an arm counts its angles from the position at which it was opened.
  static double swing(double t) { return t < 1.2 ? 0 : std::sin(2 * kPi * (5 * (t - 1.2) - 0.25)) + 1; }
  SimTime& time_;
};

/// Emulates a local service that answers after a millisecond, over a connection of 10 MB/s.
class HaplyRig : public Rig {
 public:
  explicit HaplyRig(SimTime& time) : Rig(time) {
    time_.on_step([this] { step(); });
  }
  std::unique_ptr<HapticDevice> open() override { return make_haply(std::make_unique<Wire>(*this), "emulated", {}); }
  dvec3 force() const override { return gone_ ? dvec3(0) : service_.force; }
  dvec3 at_wall() const override { return at(2); }
  int pongs() const override { return service_.pongs; }
  void attack(Attack attack) override {
    attack_ = attack;
    if (attack == Attack::kClosed) to_client_ += HaplyService::frame("", 1, 8);
    if (attack == Attack::kGone) gone_ = true;  // and the service lets go of an arm whose program has left
    if (attack == Attack::kPieces) service_.fragments = 100;
  }

 private:
  class Wire : public Link {
   public:
    explicit Wire(HaplyRig& rig) : rig_(rig) {}
    int read(std::span<std::uint8_t> buffer, Nanos timeout) noexcept override {
      const Nanos end = rig_.time_.true_now() + timeout;
      while (!rig_.gone_ && rig_.to_client_.empty() && rig_.time_.true_now() < end) {
        rig_.time_.advance(std::min(SimTime::kStep, end - rig_.time_.true_now()));
      }
      if (rig_.gone_) return -1;
      const std::size_t n = std::min(buffer.size(), rig_.to_client_.size());
      std::copy_n(rig_.to_client_.begin(), n, buffer.begin());
      rig_.to_client_.erase(0, n);
      return static_cast<int>(n);
    }
    bool write(std::span<const std::uint8_t> bytes) noexcept override {
      if (rig_.gone_) return false;
      const bool shaking_hands = !rig_.service_.open;
      const std::string answer = rig_.service_.feed({bytes.begin(), bytes.end()});
      if (shaking_hands) {
        rig_.to_client_ += answer;
      } else if (!answer.empty()) {
        rig_.asked_ = true;
        rig_.answer_at_ = (rig_.time_.true_now() / 1'000'000 + 1) * 1'000'000;
      }
      return true;
    }
    Nanos now() noexcept override { return rig_.time_.now(); }

   private:
    HaplyRig& rig_;
  };

  static dvec3 at(double swing) { return {0.004 * swing, 0.001 * swing, 0.02}; }
  void step() {
    constexpr std::size_t kPerStep = 1000, kInFlight = 1 << 16;  // bytes: 10 MB/s; what a socket holds
    service_.position = at(swing(to_seconds(time_.true_now())));
    const bool mute = attack_ == Attack::kSilence || attack_ == Attack::kPingsAlone;
    if (asked_ && !mute && time_.true_now() >= answer_at_) {
      asked_ = false;
      if (attack_ == Attack::kNotANumber) service_.position.y = std::nan("");
      if (attack_ == Attack::kLeap) service_.position.z += 0.05;
      if (attack_ == Attack::kNotANumber || attack_ == Attack::kLeap) attack_ = Attack::kNone;
      to_client_ += HaplyService::frame(service_.state_text(), service_.fragments);
    }
    std::string flood;
    if (attack_ == Attack::kPings || attack_ == Attack::kPingsAlone) flood = HaplyService::frame("", 1, 9);
    if (attack_ == Attack::kRubbish) flood = HaplyService::frame("{\"inverse3\":[{{]");
    if (attack_ == Attack::kUnasked) {
      to_client_ += HaplyService::frame(service_.state_text()) + HaplyService::frame(service_.state_text());
    }
    if (flood.empty()) return;
    for (std::size_t n = 0; n < kPerStep && to_client_.size() < kInFlight; n += flood.size()) to_client_ += flood;
  }

  HaplyService service_;
  std::string to_client_;
  bool asked_ = false;  // for a state
  Nanos answer_at_ = 0;
  Attack attack_ = Attack::kNone;
  bool gone_ = false;
};

class ArmRig : public Rig {
 public:
  ArmRig(SimTime& time, ArmProtocol protocol, std::uint32_t seed)
      : Rig(time), protocol_(protocol), arm_(test::weightless_arm()), board_(time, protocol, arm_, seed) {
    board_.hand = [](double t) { return angles(swing(t)); };
  }
  std::unique_ptr<HapticDevice> open() override {
    auto link = board_.connect();
    const ArmHello hello = greet_arm(*link, protocol_ == ArmProtocol::kText, "emulated");
    EXPECT_EQ(hello.protocol, protocol_);
    return make_arm_device(std::move(link), protocol_, arm_, {"woodenhaptics:", "", ""});
  }
  dvec3 force() const override { return board_.force(); }
  dvec3 at_wall() const override { return stylus_position(arm_, angles(2)); }
  void attack(Attack attack) override {
    if (attack == Attack::kUnasked || attack == Attack::kRubbish) board_.chatter = 20e3;
    if (attack == Attack::kRubbish) board_.garbage_reports = 1 << 30;
  }

 private:
  static dvec3 angles(double swing) { return {0.02 * swing, 0.06 * swing, 1.5707963 + 0.01 * swing}; }

  ArmProtocol protocol_;
  Arm arm_;
  EmulatedArm board_;
};

struct Outcome {
  double force_before = 0;     // N on the hand when the attack began
  double zero_after = -1;      // s from there to zero force; negative: there was none
  bool stayed_zero = true;     // from then on until the hand was free
  bool came_back = false;      // force again in a later contact
  bool ended = false;          // read() said that the device is gone
  std::uint32_t faults = 0;    // of the device, after the attack began
  double longest_read = 0;     // s, after the attack began
  double shortest_tick = 1;    // s between two samples, the same
  double worst_force = 0;      // N
  double off_reference = 0;    // N, from the force of the same hand without an attack, at most
  std::vector<double> forces;  // N, in every step of simulated time
};

constexpr double kPress = 1.5_mm;  // of the hand's way lie in the tissue

const TissueVolume& wall() {
  static const TissueVolume volume(
      read_solids(Json::parse(R"({"voxel_mm": 0.5, "solids": [{"tissue": "enamel", "solid": {"box": {
        "center_mm": [10, 0, 0], "size_mm": [20, 30, 30]}}}]})",
                              "wall")));
  return volume;
}

/// Runs one attack. It begins at the first tick later than `after` in which the force on the hand is larger than
/// `begins` (N). `reference`: the forces without an attack.
Outcome run(Rig& rig, SimTime& time, Attack attack, Nanos after, double begins, double stall,
            const std::vector<double>* reference = nullptr) {
  std::unique_ptr<HapticDevice> device = rig.open();
  SafeDevice::Options options = SafeDevice::options_for(device->info());
  options.watchdog_thread = false;
  options.clock = [&] { return time.now(); };
  SafeDevice hand(std::move(device), options);
  ServoSettings settings;
  settings.tool.diameter = settings.tool.length = 2.0_mm;
  settings.tool.cuts = false;
  for (Material& m : settings.materials) m = {1000, 30e9, 0.2, 0.15, 2950, dvec3(0.9)};
  settings.position_step = hand.info().position_step;
  LockStep steps(wall().clone(), settings);
  // The wall's face is x = 0. The ball touches it one millimetre before its centre reaches the face.
  const dvec3 offset = dvec3(kPress - 1.0_mm, 0, 0) - rig.at_wall();

  Outcome out;
  bool attacked = false, was_free = false;
  Nanos began = 0, next_watch = 0;
  time.on_step([&] {
    if (time.true_now() >= next_watch) {  // the watchdog's own thread: wakes when it asked to
      const Nanos wake = hand.watch(time.now());
      next_watch = time.true_now() + std::clamp<Nanos>(wake - time.now(), SimTime::kStep, 10'000'000);
    }
    const double force = glm::length(rig.force());
    out.worst_force = std::max(out.worst_force, force);
    if (reference && out.forces.size() < reference->size()) {
      out.off_reference = std::max(out.off_reference, std::abs(force - (*reference)[out.forces.size()]));
    }
    out.forces.push_back(force);
    if (!attacked) return;
    if (force < 1e-9) {
      if (out.zero_after < 0) out.zero_after = to_seconds(time.true_now() - began);
    } else if (out.zero_after >= 0) {
      (was_free ? out.came_back : out.stayed_zero) = was_free;
    }
  });

  HandSample sample;
  ServoTick tick;
  Cut cut;
  double free_for = 0;
  Nanos last = 0;
  const Nanos end = time.true_now() + 1'500'000'000;
  while (time.true_now() < end) {
    const Nanos before = time.true_now();
    const bool alive = hand.read(sample);
    if (attacked) out.faults |= hand.faults();
    if (attacked && before >= began + 1'000'000) {
      out.longest_read = std::max(out.longest_read, to_seconds(time.true_now() - before));
      if (last > 0 && alive) out.shortest_tick = std::min(out.shortest_tick, to_seconds(sample.t - last));
    }
    if (!alive) {
      out.ended = true;
      break;
    }
    last = sample.t;
    sample.X_WT.p += offset;
    sample.faults = hand.faults();
    steps.tick(sample, tick, cut);
    hand.contact(tick.depth > 0);
    free_for = tick.depth == 0 && hand.faults() == 0 ? free_for + 1e-3 : 0;
    was_free |= attacked && free_for > 0.04;
    hand.write(tick.f_T_W, tick.tau_T_W);
    const double force = glm::length(rig.force());
    if (!attacked && attack != Attack::kNone && time.true_now() > after && force > begins) {
      attacked = true;
      began = time.true_now();
      out.force_before = force;
      rig.attack(attack);
      if (attack == Attack::kStalledServo) time.advance(from_seconds(stall));
    }
  }
  time.advance(5'000'000);
  return out;
}

constexpr double kTwoMilliseconds = 0.0021;  // as seen in steps of 0.1 ms
constexpr double kSpaced = 0.49e-3;          // s: two samples are at least half a period apart

/// An attack, and what must follow.
struct Row {
  const char* title;
  Attack attack;
  bool goes_on = false;              // the contact continues as without the attack; otherwise the force becomes zero
  std::optional<bool> ends = false;  // read() reports that the device is gone; without a value, both are allowed
  std::uint32_t faults = 0;          // that it must report
};

template <class Make>
void campaign(const Row& row, Make make) {
  const auto& [title, attack, goes_on, ends, faults] = row;
  Outcome reference;
  {
    SimTime time;
    auto rig = make(time);
    reference = run(*rig, time, Attack::kNone, 0, 0, 0);
    ASSERT_GT(reference.worst_force, 1.2);
  }
  std::mt19937 random(static_cast<std::uint32_t>(attack) + 1);
  for (int i = 0; i < test::campaign(12); ++i) {
    const Nanos after = from_seconds(std::uniform_real_distribution<double>(1.6, 1.8)(random));
    const double begins = std::uniform_real_distribution<double>(0.2, 1.1)(random),
                 stall = std::uniform_real_distribution<double>(0.003, 0.3)(random);
    SimTime time;
    auto rig = make(time);
    const Outcome o = run(*rig, time, attack, after, begins, stall, goes_on ? &reference.forces : nullptr);
    SCOPED_TRACE(testing::Message() << "run " << i << ": " << o.force_before << " N before, zero after "
                                    << 1e3 * o.zero_after << " ms, longest read " << 1e3 * o.longest_read << " ms");
    ASSERT_GT(o.force_before, 0.2);
    ASSERT_LT(o.worst_force, 2.5);
    ASSERT_LT(o.longest_read, 0.15);
    ASSERT_GT(o.shortest_tick, kSpaced);
    ASSERT_EQ(o.ended, ends.value_or(o.ended));
    ASSERT_EQ((o.faults & bits(Fault::kDeviceLost)) != 0, o.ended);
    ASSERT_EQ(o.faults & faults, faults);
    ASSERT_EQ(rig->pongs() > 0, attack == Attack::kPings || attack == Attack::kPingsAlone);
    if (goes_on) {
      ASSERT_LT(o.off_reference, 0.3);  // two milliseconds of that hand's way
    } else {
      ASSERT_GE(o.zero_after, 0);
      ASSERT_LE(o.zero_after, kTwoMilliseconds);
      ASSERT_TRUE(o.stayed_zero);
    }
    if (attack == Attack::kNotANumber || attack == Attack::kLeap || attack == Attack::kStalledServo) {
      ASSERT_TRUE(o.came_back);
    }
  }
}

class HaplyAttacks : public testing::TestWithParam<Row> {};
TEST_P(HaplyAttacks, AreNotFeltOrSetTheForceToZeroUntilTheHandIsFree) {
  campaign(GetParam(), [](SimTime& time) { return std::make_unique<HaplyRig>(time); });
}
INSTANTIATE_TEST_SUITE_P(Service, HaplyAttacks,
                         testing::Values(Row{"AFloodOfPingsBetweenStatesIsNotFelt", Attack::kPings, true},
                                         Row{"AFloodOfPingsAndNoStateIsALostDevice", Attack::kPingsAlone, false, true},
                                         Row{"UnrequestedStatesDoNotSpeedUpTheServoAndAreNotFelt", Attack::kUnasked,
                                             true},
                                         Row{"AFloodOfInvalidDataSetsTheForceToZero", Attack::kRubbish, false, false,
                                             bits(Fault::kBadInput)},
                                         Row{"AServiceThatFallsSilentIsALostDevice", Attack::kSilence, false, true},
                                         Row{"AServiceThatSaysGoodbyeIsALostDevice", Attack::kClosed, false, true},
                                         Row{"AConnectionThatBreaksIsALostDevice", Attack::kGone, false, true},
                                         Row{"AStateOfNansSetsTheForceToZeroUntilTheHandIsFree", Attack::kNotANumber},
                                         Row{"AJumpingStateSetsTheForceToZeroUntilTheHandIsFree", Attack::kLeap},
                                         Row{"FragmentedStatesAreNotFelt", Attack::kPieces, true},
                                         Row{"AStalledProcessHasNoForceUntilTheHandIsFree", Attack::kStalledServo}),
                         [](const auto& param) { return param.param.title; });

class ArmAttacks : public testing::TestWithParam<ArmProtocol> {
 protected:
  static void attack(const Row& row) {
    campaign(row, [](SimTime& time) { return std::make_unique<ArmRig>(time, GetParam(), 1); });
  }
};
TEST_P(ArmAttacks, UnrequestedReportsDoNotSpeedUpTheServoAndAreNotFelt) {
  attack({"", Attack::kUnasked, true});
}
TEST_P(ArmAttacks, AFloodOfInvalidDataSetsTheForceToZero) {
  attack({"", Attack::kRubbish, false, std::nullopt});  // now and then rubbish is a place where the arm could be
}
INSTANTIATE_TEST_SUITE_P(Arms, ArmAttacks, testing::ValuesIn(test::kArmProtocols),
                         [](const auto& param) { return test::name_of(param.param); });

}  // namespace
}  // namespace typodont::haptics
