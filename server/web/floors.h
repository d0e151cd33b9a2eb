// Floors as grid maps of ROS's map servers: GET /floors/MAP/floor_N.yaml and .pgm, and
// their rooms: floor_N.rooms.json.
#pragma once

#include "server/http/exchange.h"
#include "server/rpc/gate.h"
#include "server/web/stream_slots.h"

namespace isthmus::web {

// MAP is a session in the map, or its number; N counts from the lowest floor, 0. ?resolution= is
// the edge of a cell, ?box= as of the map; the YAML names the PGM of the same address and query.
// GET /floors/MAP lists the floors as JSON:
// [{"floor":0,"lowest_m":..,"highest_m":..,"yaml":"floor_0.yaml","pgm":"floor_0.pgm",
// "rooms":"floor_0.rooms.json"}], heights of sensors. NotFound for a floor that is not there; 503
// where as many as `slots` has are being drawn.
http::Response AnswerFloor(const http::Request& request, rpc::Gate& gate, StreamSlots* slots);

}  // namespace isthmus::web
