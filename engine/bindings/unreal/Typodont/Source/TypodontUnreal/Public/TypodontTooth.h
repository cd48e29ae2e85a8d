// Hard tissue that can be felt and drilled, for Unreal Engine 5: place this actor in a level. It uses only the C
// interface (typodont.h). The servo runs at 1 kHz on its own thread, the tissue on a second thread. Each brick of the
// tissue's surface is a procedural mesh; a frame replaces only the meshes of changed bricks.
//
// Lengths in the actor's frame are centimetres, as everywhere in Unreal, so a tooth has a size of one unit; scale the
// actor to enlarge it. W is right-handed and Unreal is left-handed: the actor's y axis is -y of W.
#pragma once

#include "CoreMinimal.h"
#include "GameFramework/Actor.h"
#include "TypodontTooth.generated.h"

class FTypodontBench;
class UMaterialInterface;
class UProceduralMeshComponent;

UCLASS()
class TYPODONTUNREAL_API ATypodontTooth : public AActor {
  GENERATED_BODY()

 public:
  ATypodontTooth();

  /** A shipped scene, a scene file, or a scene as JSON text. */
  UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Typodont")
  FString Scene = TEXT("molar-caries");

  /** The hand moves this actor. Its origin is the centre of the tool's head, and its z axis points along the shank. */
  UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Typodont")
  TObjectPtr<AActor> Hand;

  /** This actor is shown as the tool: it follows the hand, but stays outside the tissue. */
  UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Typodont")
  TObjectPtr<AActor> ShownTool;

  UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Typodont")
  TObjectPtr<UMaterialInterface> Material;

  /** 0..1 */
  UPROPERTY(EditAnywhere, BlueprintReadWrite, Category = "Typodont")
  float Pedal = 0;

  /** Force of the newest tick on the hand, N, in the actor's axes. */
  UPROPERTY(BlueprintReadOnly, Category = "Typodont")
  FVector Force = FVector::ZeroVector;

  /** Volume removed since the start, mm3. */
  UPROPERTY(BlueprintReadOnly, Category = "Typodont")
  double Removed = 0;

  /** Why there is no tissue; empty if there is. */
  UPROPERTY(BlueprintReadOnly, Category = "Typodont")
  FString Error;

  /** Reverts the last stroke. False if there is none. */
  UFUNCTION(BlueprintCallable, Category = "Typodont")
  bool Undo();

  virtual void BeginPlay() override;
  virtual void EndPlay(const EEndPlayReason::Type Reason) override;
  virtual void Tick(float DeltaSeconds) override;

 private:
  void SendHand();
  void ShowChangedBricks();

  UPROPERTY(Transient)
  TMap<FIntVector, TObjectPtr<UProceduralMeshComponent>> Bricks;

  TSharedPtr<FTypodontBench> Bench;
};
