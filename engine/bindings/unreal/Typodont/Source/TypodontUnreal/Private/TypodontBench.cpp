#include "TypodontBench.h"

#include "HAL/PlatformProcess.h"
#include "HAL/PlatformTime.h"
#include "Math/Quat.h"
#include "Math/UnrealMathUtility.h"
#include "Misc/ScopeLock.h"

FTypodontLoop::FTypodontLoop(const TCHAR* Name, EThreadPriority Priority, TFunction<void()> InStep)
    : Step(MoveTemp(InStep)), Thread(FRunnableThread::Create(this, Name, 0, Priority)) {}

FTypodontLoop::~FTypodontLoop() {
  if (Thread) Thread->Kill(true);  // calls Stop() and waits for the thread
  delete Thread;
}

uint32 FTypodontLoop::Run() {
  while (!bStop) Step();
  return 0;
}

namespace {

constexpr double Period = 1e-3;  // s, period of the servo
// s, time constant of the low-pass filter between the hand's pose in the game and the hand's pose in the servo
constexpr double Smoothing = 0.02;

/**
 * The game thread moves the hand once a frame, so the servo's hand follows it smoothly. For a hand that jumps once a
 * frame, the energy ledger would expect a jump back, and reduce the force (docs/passivity.md).
 */
typodont_pose Follow(const typodont_pose& From, const typodont_pose& To) {
  const double Fraction = 1 - FMath::Exp(-Period / Smoothing);
  const FQuat A(From.q[1], From.q[2], From.q[3], From.q[0]), B(To.q[1], To.q[2], To.q[3], To.q[0]);
  const FQuat Q = FQuat::Slerp(A, B, Fraction);
  typodont_pose X{{}, {Q.W, Q.X, Q.Y, Q.Z}};
  for (int32 i = 0; i < 3; ++i) X.p[i] = From.p[i] + Fraction * (To.p[i] - From.p[i]);
  return X;
}

}  // namespace

FTypodontBench::~FTypodontBench() {
  ServoLoop.Reset();
  TissueLoop.Reset();
  typodont_servo_free(Servo);
  typodont_core_free(Core);
}

FString FTypodontBench::Open(const FString& Scene, const typodont_pose& Hand) {
  typodont_scene* Opened = nullptr;
  const FTCHARToUTF8 Converted(*Scene);
  const auto* Text = reinterpret_cast<const char*>(Converted.Get());
  const bool bFailed = (*Text == '{' ? typodont_scene_parse(Text, nullptr, nullptr, &Opened)
                                     : typodont_scene_open(Text, nullptr, &Opened)) ||
                       typodont_core_new(Opened, nullptr, nullptr, &Core) || typodont_core_servo(Core, Hand.p, &Servo);
  const FString Reason = bFailed ? FString(UTF8_TO_TCHAR(typodont_error())) : FString();
  typodont_scene_free(Opened);
  if (bFailed) return Reason;

  typodont_sample Sample{};
  Sample.struct_size = sizeof Sample;
  Sample.X_WT = Felt = Hand;
  Send(Sample);
  Start = FPlatformTime::Seconds();
  ServoLoop = MakeUnique<FTypodontLoop>(TEXT("TypodontServo"), TPri_TimeCritical, [this] { ServoStep(); });
  TissueLoop = MakeUnique<FTypodontLoop>(TEXT("TypodontTissue"), TPri_AboveNormal, [this] { TissueStep(); });
  return Reason;
}

void FTypodontBench::ServoStep() {
  for (double Left; (Left = Start + Ticked * Period - FPlatformTime::Seconds()) > 0;)
    FPlatformProcess::SleepNoStats(Left > 2e-4 ? static_cast<float>(Left - 1e-4) : 0.0f);
  typodont_sample Sample = Samples.SwapAndRead();
  Sample.X_WT = Follow(Felt, Sample.X_WT);
  Sample.t_ns = Ticked * 1000000;
  ++Ticked;
  typodont_tick Tick{};
  Tick.struct_size = sizeof Tick;
  // If the hand's pose is invalid, this tick has zero force and a fault, and Felt keeps the last valid pose.
  if (typodont_servo_tick(Servo, &Sample, &Tick, nullptr) == TYPODONT_OK) Felt = Sample.X_WT;
  Ticks.WriteAndSwap(Tick);
}

void FTypodontBench::TissueStep() {
  int32 bWorked = 0;
  {
    FScopeLock Lock(&CoreLock);
    typodont_core_carve(Core, &bWorked);
  }
  if (!bWorked) FPlatformProcess::SleepNoStats(3e-4f);
}

bool FTypodontBench::Undo() {
  FScopeLock Lock(&CoreLock);
  int32 bDone = 0;
  return typodont_core_undo(Core, &bDone) == TYPODONT_OK && bDone;
}

void FTypodontBench::ChangedBricks(TFunction<void(const typodont_mesh_part&)> Show) {
  FScopeLock Lock(&CoreLock);
  const typodont_mesh_part* Parts = nullptr;
  size_t Count = 0;
  if (typodont_core_mesh(Core, &Parts, &Count) != TYPODONT_OK) return;
  for (size_t i = 0; i < Count; ++i) Show(Parts[i]);
}
