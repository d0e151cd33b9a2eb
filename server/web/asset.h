// The files of the viewer, as they are served.
#pragma once

#include "core/asset.h"
#include "server/http/exchange.h"

namespace isthmus {

// The viewer's, of client/viewer; none where it was not built.
const Assets& ViewerAssets();

namespace web {

// The asset of the request's path, "/" being /index.html. Assets below /assets/ have a hash of
// their content in their names and may be kept for ever. If there is no asset at all, "/" says so.
http::Response AnswerAsset(const http::Request& request, const Assets& assets);

}  // namespace web
}  // namespace isthmus
