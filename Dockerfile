# worldgen, ready to use, as an ordinary user in /work:
#   docker build -t worldgen .
#   docker run --rm -v "$PWD:/work" worldgen fuzz --controller ./robot.py:Robot --out failures/
FROM python:3.13-slim

# Nothing is kept but what is used.
ENV PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_NO_CACHE_DIR=1 PYTHONDONTWRITEBYTECODE=1

COPY . /opt/worldgen
RUN pip install "/opt/worldgen[studio]" && rm -rf /opt/worldgen

RUN useradd --create-home worldgen
USER worldgen
WORKDIR /work
ENTRYPOINT ["worldgen"]
CMD ["--help"]
