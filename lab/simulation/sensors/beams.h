// Effects of light beams that do not simply end on the first surface; the steps of Disturb.
#pragma once

#include "lab/simulation/sensors/effects.h"

namespace isthmus::simulation {

// A pane sends back what meets it squarely, mirrors some and lets most pass; all but the first look
// as far as the light has come.
void ThroughGlass(const Effects& effects, const CastScan& scan, const Trace& trace, Random& random);

// Leaves that are hit in part: an echo from between them and what is behind, or from behind.
void ThroughFoliage(const Effects& effects, const CastScan& scan, const Trace& trace,
                    Random& random);

// Beams beside a retro-reflector see it too.
void Bloom(const Effects& effects, const CastScan& scan, Random& random);

// A beam that meets an edge sees something between the near and the far side.
void MixEdges(const Effects& effects, const CastScan& scan, Random& random);

}  // namespace isthmus::simulation
