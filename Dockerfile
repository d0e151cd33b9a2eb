# One image for the server and the demo robots: the programs with what they need.
FROM debian:12 AS build
WORKDIR /src
COPY scripts/packages scripts/packages
RUN apt-get update \
 && grep -v '^#' scripts/packages | xargs apt-get install -y --no-install-recommends \
 && rm -rf /var/lib/apt/lists/*
COPY . .
RUN cmake --preset release -DISTHMUS_TESTS=OFF \
 && cmake --build build/release --target isthmus isthmus-offline isthmus-server \
      isthmus-fleet isthmus-worker isthmus-lab isthmus-loadgen \
 && for part in client offline server fleet lab; do \
      DESTDIR=/out cmake --install build/release --component $part; \
    done \
 # The shared libraries the programs really load, so that the image needs no package list.
 && mkdir -p /out/lib \
 && ldd /out/usr/local/bin/* /out/usr/local/libexec/isthmus/* \
    | awk '$3 ~ "^/" { print $3 }' | sort -u \
    | grep -vE '/(libc|libm|libdl|librt|libpthread|ld-linux[^/]*)\.so' \
    | xargs cp -L -t /out/lib

FROM debian:12-slim
# /drive is for the recordings of the demo: a volume there belongs to whom it belongs to here.
RUN useradd --system --uid 10001 --create-home --home-dir /var/lib/isthmus isthmus \
 && install -d -o isthmus /drive
COPY --from=build /out/usr/local/ /usr/local/
COPY --from=build /out/lib/ /usr/local/lib/isthmus/
# By which object stores are known (storage.bucket).
COPY --from=build /etc/ssl/certs/ca-certificates.crt /etc/ssl/certs/
RUN echo /usr/local/lib/isthmus > /etc/ld.so.conf.d/isthmus.conf && ldconfig
USER isthmus
VOLUME /var/lib/isthmus
EXPOSE 50051
# In plain text: who may reach the port is a matter of how it is published. With certificates
# mounted, give the settings of docs/network.md instead.
CMD ["isthmus-server", "--data", "/var/lib/isthmus", "--listen", "0.0.0.0:50051", "--insecure"]
